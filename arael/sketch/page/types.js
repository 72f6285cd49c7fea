/**
 * Types of the page: records of a sketch as the server sends them, replies, places, previews.
 *
 * @typedef {[number, number]} Point  x and y, in the sketch (y up) or on the screen (y down)
 *
 * @typedef {"point"|"line"|"circle"|"arc"|"ellipse"|"earc"|"bezier"|"bspline"} EntityKind
 *
 * @typedef {object} Entity
 * @property {string} name
 * @property {EntityKind} kind
 * @property {number} at  offset of its first number in `Store.values`
 * @property {number} size  how many numbers it has
 * @property {boolean} [construction]
 * @property {boolean} [quiet]
 * @property {"solid"|"dashed"|"dashdot"} [style]
 * @property {string} [text]  lettered along a line, the frame of a text
 * @property {boolean} [clockwise]  an arc whose `start` is where its numbers end
 *
 * @typedef {object} Constraint
 * @property {string} name
 * @property {string} kind
 * @property {string[]} args
 * @property {number[]} [numbers]
 * @property {number} [side]
 * @property {string} [mode]
 * @property {boolean} [active]
 * @property {boolean} [forced]
 *
 * @typedef {{text: string, number: number}} Amount
 *
 * @typedef {object} Dimension
 * @property {string} name
 * @property {string} kind
 * @property {string[]} args
 * @property {Amount|null} [value]
 * @property {Amount|null} [low]
 * @property {Amount|null} [high]
 * @property {boolean} [derived]
 * @property {number} [side]
 * @property {string} [mode]
 * @property {boolean} [active]
 * @property {boolean} [forced]
 * @property {string} [broken]
 * @property {number|null} [offset]
 * @property {number|null} [along]
 *
 * @typedef {{name: string, amount: Amount, broken?: string}} Parameter
 *
 * @typedef {object} Group
 * @property {string} name
 * @property {string} kind
 * @property {string[]} [sources]
 * @property {string[]} [results]
 * @property {string[]} [owned]
 * @property {Record<string, unknown>} [options]
 *
 * @typedef {object} Tables
 * @property {Entity[]} [entities]
 * @property {Constraint[]} [constraints]
 * @property {Dimension[]} [dimensions]
 * @property {Parameter[]} [parameters]
 * @property {Group[]} [groups]
 *
 * @typedef {"free"|"defined"|"redundant"|"impossible"} State
 *
 * @typedef {object} Verdict
 * @property {number} revision
 * @property {number} freedoms
 * @property {Record<string, State>} entities
 * @property {Record<string, string>} constraints  "redundant", "impossible" or "here"
 * @property {Record<string, State>} points
 *
 * @typedef {object} Failure
 * @property {string} code
 * @property {string} message
 * @property {string} [hint]
 * @property {number} [from]
 * @property {number} [to]
 * @property {string[]} [names]
 * @property {string} [help]
 *
 * @typedef {object} Reply
 * @property {boolean} ok
 * @property {string} text
 * @property {string[]} [names]
 * @property {string[]} [created]
 * @property {string[]} [notes]
 * @property {Failure} [error]
 * @property {unknown} [data]
 *
 * @typedef {"endpoint"|"centre"|"midpoint"|"quadrant"|"intersection"|"nearest"|"tangent"|"perpendicular"|"alignment"|"grid"} SnapKind
 *
 * @typedef {object} Snap
 * @property {SnapKind} kind
 * @property {string[]} handles  points and curves it refers to
 * @property {string} text  in words, for the status line
 * @property {string[]} extras  automatic constraints: `{p}` stands for the new point, `{c}` for the new curve
 * @property {[Point, Point][]} [guides]  dashed lines that show an alignment
 *
 * @typedef {object} Place
 * @property {Point} at  in the sketch
 * @property {Snap|null} snap
 * @property {Point} screen  where the pointer is, in pixels
 * @property {boolean} [bare]  automatic constraints are switched off
 *
 * @typedef {object} Line
 * @property {"line"} type
 * @property {number} x1
 * @property {number} y1
 * @property {number} x2
 * @property {number} y2
 *
 * @typedef {object} Conic  circle, ellipse, or an arc of one
 * @property {"conic"} type
 * @property {number} cx
 * @property {number} cy
 * @property {number} rx
 * @property {number} ry
 * @property {number} turn  rotation of the first axis, radians
 * @property {number} start  angle (eccentric where the radii differ) of the start, from the first axis
 * @property {number} sweep  signed, counter-clockwise positive
 * @property {boolean} closed
 *
 * @typedef {object} Spline  cubic pieces, eight numbers each
 * @property {"spline"} type
 * @property {number[][]} pieces
 * @property {Point[]} poles
 *
 * @typedef {Line|Conic|Spline} Curve
 *
 * @typedef {object} Preview
 * @property {Curve[]} [curves]
 * @property {Curve[]} [guides]  drawn dashed and pale
 * @property {Point[]} [points]
 * @property {{at: Point, along: Point}[]} [cuts]  where a curve of this direction would be cut
 * @property {{at: Point, text: string}[]} [labels]
 * @property {{text: string, from: Point, to: Point}[]} [texts]  with their frames
 * @property {string[]} [names]  existing things shown as picked
 * @property {import("./draw/lines.js").Drawn} [dimension]  a dimension that would be made
 * @property {{from: Point, to: Point}} [box]  a selection box, in pixels
 *
 * @typedef {object} Field  a value that can be typed while drawing
 * @property {string} id
 * @property {string} title
 * @property {string} text  what has been typed, "" if the pointer decides
 * @property {number} value  what the pointer gives now
 * @property {"length"|"angle"|"count"|"text"} quantity
 *
 * @typedef {object} ToolSpec
 * @property {string} id
 * @property {string} title
 * @property {string} key  "" if it has none
 * @property {string} group  "select", "create", "modify" or "dimension"
 * @property {string} hint
 * @property {(app: import("./app.js").App) => import("./tools/tool.js").Tool} make
 */

export {};
