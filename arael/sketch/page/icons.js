/** Icons: strokes in a square of 20, in the colour of the text. A capital M begins a stroke; "f" before a path fills it. */

const DOT = (/** @type {number} */ x, /** @type {number} */ y, r = 1.6) =>
  `fM${x - r} ${y}a${r} ${r} 0 1 0 ${2 * r} 0a${r} ${r} 0 1 0 ${-2 * r} 0`;
const CIRCLE = (/** @type {number} */ x, /** @type {number} */ y, /** @type {number} */ r) =>
  `M${x - r} ${y}a${r} ${r} 0 1 0 ${2 * r} 0a${r} ${r} 0 1 0 ${-2 * r} 0`;
const ELLIPSE = "M2.5 10a7.5 4.5 0 1 0 15 0a7.5 4.5 0 1 0 -15 0";
const ARROWS = "M3 10h14M5.5 7.5L3 10l2.5 2.5M14.5 7.5L17 10l-2.5 2.5";
const EYE = "M2 10c3-6 13-6 16 0c-3 6-13 6-16 0z";
const PAGE = "M5 2.5h7l3 3v12h-10zM12 2.5v3h3";

/** @type {Readonly<Record<string, string[]>>} */
const ICONS = {
  // tools
  tool_select: ["M5 3l10 7-5 .8L7.5 16z"],
  tool_line: ["M4 16L16 4", DOT(4, 16), DOT(16, 4)],
  tool_rect: ["M3.5 5.5h13v9h-13z", DOT(3.5, 14.5), DOT(16.5, 5.5)],
  tool_rect3: ["M3 11L12 4l5 5-9 7z", DOT(3, 11), DOT(12, 4), DOT(17, 9)],
  tool_rectcenter: ["M3.5 5.5h13v9h-13z", DOT(10, 10), DOT(16.5, 5.5)],
  tool_circle: [CIRCLE(10, 10, 7), DOT(10, 10)],
  tool_circle2: [CIRCLE(10, 10, 7), DOT(3, 10), DOT(17, 10)],
  tool_circle3: [CIRCLE(10, 10, 7), DOT(10, 3), DOT(3.9, 13.5), DOT(16.1, 13.5)],
  tool_circle2t: [CIRCLE(11, 9, 5.2), "M3 14.2h15M5.8 2v15"],
  tool_circle3t: [CIRCLE(10, 11.6, 4), "M2 15.6h16L10 2.5z"],
  tool_arc: ["M3 15A9 9 0 0 1 17 15", DOT(3, 15), DOT(17, 15), DOT(10, 10.6)],
  tool_arc_center: ["M4 13A7 7 0 0 1 16 9", DOT(10, 14), DOT(4, 13), DOT(16, 9)],
  tool_arc_tangent: ["M2 15h6M8 15a7 7 0 0 0 7-7", DOT(8, 15), DOT(15, 8)],
  tool_ellipse: [ELLIPSE, DOT(10, 10)],
  tool_earc3: ["M2.5 12a7.5 5 0 0 1 15 0", DOT(2.5, 12), DOT(17.5, 12), DOT(10, 7)],
  tool_earc_center: ["M2.5 10a7.5 4.5 0 0 1 15 0", DOT(10, 10), DOT(2.5, 10), DOT(17.5, 10)],
  tool_earc_tangent: ["M2 16h5c7 0 9-5 9-11", DOT(7, 16), DOT(16, 5)],
  tool_earc_rtangent: ["M2 16h5c7 0 9-5 9-11M13.5 7L16 4.5 18.5 7"],
  tool_spline: ["M3 14C6 2 12 20 17 5", DOT(3, 14), DOT(17, 5)],
  tool_spline_through: ["M3 14C6 2 8 6 10 10S14 16 17 5", DOT(3, 14), DOT(10, 10), DOT(17, 5)],
  tool_bezier: ["M3 15C5 3 14 3 17 15M3 15L6 5M17 15L13.5 5"],
  tool_slot: ["M6.5 6h7a4 4 0 0 1 0 8h-7a4 4 0 0 1 0-8z", DOT(6.5, 10, 1.2), DOT(13.5, 10, 1.2)],
  tool_polygon: ["M6 3.5h8l4 6.5-4 6.5h-8L2 10z"],
  tool_point: [DOT(10, 10, 2.4), "M10 3v3M10 14v3M3 10h3M14 10h3"],
  tool_text: ["M4 5V3.5h12V5M10 3.5v13M7.5 16.5h5"],
  tool_dimension: ["M3 4v12M17 4v12", ARROWS],
  tool_measure: ["M3 13L13 3l4 4L7 17zM6 10l1.8 1.8M8.5 7.5l1.8 1.8M11 5l1.8 1.8"],
  tool_fillet: ["M4 3v6a7 7 0 0 0 7 7h6", "M4 16h2M4 13v3"],
  tool_chamfer: ["M4 3v7l6 6h7", "M4 16h2M4 13v3"],
  tool_trim: ["M4 4l8.5 8.5M16 4L7.5 12.5", CIRCLE(5.5, 14.5, 2.2), CIRCLE(14.5, 14.5, 2.2)],
  tool_split: ["M2.5 10h5M12.5 10h5M10 3v14", DOT(7.5, 10), DOT(12.5, 10)],
  tool_extend: ["M2.5 10h6M10.5 10h4M17 3v14M12.5 7.5L15 10l-2.5 2.5"],
  tool_offset: ["M3 17V8a5 5 0 0 1 5-5h9M8 17v-6a3 3 0 0 1 3-3h6"],
  tool_offset_line: ["M3 14L14 3M6 17L17 6"],
  tool_mirror: ["M10 2v16", "M7.5 5v10L2.5 15zM12.5 5v10l5 0z"],
  tool_pattern_circular: [CIRCLE(10, 3.8, 1.8), CIRCLE(15.4, 7.7, 1.8), CIRCLE(13.3, 14.9, 1.8), CIRCLE(6.7, 14.9, 1.8), CIRCLE(4.6, 7.7, 1.8)],
  tool_pattern_rect: ["M3 3h4v4h-4zM13 3h4v4h-4zM3 13h4v4h-4zM13 13h4v4h-4z"],
  tool_move: ["M10 2.5v15M2.5 10h15M8 4.5l2-2 2 2M8 15.5l2 2 2-2M4.5 8l-2 2 2 2M15.5 8l2 2-2 2"],
  tool_rotate: ["M16 11a6 6 0 1 1-2-5.5M16.5 2.5v4h-4", DOT(10, 10.5, 1.3)],
  tool_scale: ["M3 3h14v14h-14zM3 9h8v8M12 8l3-3M12.5 5H15v2.5"],
  // constraints
  coincident: [CIRCLE(10, 10, 3), DOT(10, 10, 1.5), "M3 3l4.8 4.8M17 3l-4.8 4.8"],
  point_on: ["M3 16C6 6 12 4 17 4", CIRCLE(8.6, 7.4, 2.6)],
  midpoint: ["M3 10h14M3 7v6M17 7v6", DOT(10, 10, 2)],
  horizontal: ["M3 10h14", "M5 6.5h2M13 6.5h2"],
  vertical: ["M10 3v14", "M13.5 5v2M13.5 13v2"],
  parallel: ["M4 16L10 4M10 16L16 4"],
  perpendicular: ["M10 3v13M3 16h14M10 12h4v4"],
  tangent: [CIRCLE(10, 11.5, 5.5), "M2.5 6h15"],
  equal: ["M4 7.5h12M4 12.5h12"],
  equal_length: ["M4 7.5h12M4 12.5h12"],
  equal_radius: ["M4 7.5h12M4 12.5h12"],
  equal_angle: ["M3 9h6L5.5 3M11 17h6l-3.5-6M6.6 9a3 3 0 0 0-.7-3M14.6 17a3 3 0 0 0-.7-3"],
  collinear: ["M2.5 17.5l5-5M12.5 7.5l5-5M9 11l2-2"],
  concentric: [CIRCLE(10, 10, 7), CIRCLE(10, 10, 3.5)],
  symmetry: ["M10 2v3M10 8.5v3M10 15v3", DOT(4, 10, 2), DOT(16, 10, 2), "M6 10h8"],
  smooth: ["M2.5 15c6 0 6-10 15-10", DOT(9.3, 9.6, 1.6)],
  on_normal: ["M3 15C6 9 11 7 17 7M9.5 9L6.5 2.5", DOT(6.5, 2.5)],
  lock: ["M5 9h10v8h-10zM7 9V6.5a3 3 0 0 1 6 0V9"],
  unlock: ["M5 9h10v8h-10zM7 9V6.5a3 3 0 0 1 5.8-1"],
  fix: ["M3 7h14M5 7l-2 4M9 7l-2 4M13 7l-2 4M17 7l-2 4"],
  image: ["M3 11h6v6h-6zM11 3h6v6h-6z", "M7 8c0-2 1-3 3-3"],
  // dimensions
  length: ["M3 5v10M17 5v10", ARROWS],
  distance: ["M3 5v10M17 5v10M6 10h8", DOT(3, 10), DOT(17, 10)],
  hdistance: ["M3 12v4M17 12v4M3 14h14", DOT(3, 9), DOT(17, 4)],
  vdistance: ["M12 3h4M12 17h4M14 3v14", DOT(9, 3), DOT(4, 17)],
  radius: [CIRCLE(10, 10, 7), "M10 10l5-5", DOT(10, 10, 1.3)],
  diameter: [CIRCLE(10, 10, 7), "M5 15L15 5"],
  radius_b: [ELLIPSE, "M10 10V5.5", DOT(10, 10, 1.3)],
  sweep: ["M3 15A9 9 0 0 1 17 15M10 17L3 15M10 17l7-2"],
  arc_length: ["M3 15A9 9 0 0 1 17 15M3 9A11 11 0 0 1 17 9"],
  angle: ["M16 16H4L13 4M10 16a6 6 0 0 0-2.4-4.8"],
  xangle: ["M17 16H3M3 16L14 5M10 16a7 7 0 0 0-2-5"],
  total_length: ["M3 15l5-8 4 5 5-8", DOT(3, 15), DOT(8, 7), DOT(12, 12), DOT(17, 4)],
  area: ["M4 4h12v12h-12zM4 10l6-6M4 16L16 4M10 16l6-6"],
  // edit, view, files
  undo: ["M7 4L3 8l4 4M3 8h8a5 5 0 0 1 0 9H8"],
  redo: ["M13 4l4 4-4 4M17 8H9a5 5 0 0 0 0 9h3"],
  delete: ["M4 5.5h12M8 5.5V3.5h4v2M5.5 5.5l.8 11.5h7.4l.8-11.5M8.3 8.5v5.5M11.7 8.5v5.5"],
  construction: ["M3 17L6 14M8.5 11.5l3-3M14 6l3-3"],
  quiet: [EYE, "M4 16L16 4"],
  style_solid: ["M3 10h14"],
  style_dashed: ["M2.5 10h4M8 10h4M13.5 10h4"],
  style_dashdot: ["M2.5 10h5M10 10h.5M13 10h5"],
  freeze: ["M10 2.5v15M3.5 6.2l13 7.6M3.5 13.8l13-7.6"],
  set_derived: ["M7 4c-3 3-3 9 0 12M13 4c3 3 3 9 0 12M8 10h4"],
  set_driven: ["M3 5v10M17 5v10", ARROWS],
  switch_off: ["M10 3v6M6 5.5a6 6 0 1 0 8 0"],
  switch_on: ["M10 3v6M6 5.5a6 6 0 1 0 8 0", DOT(10, 11.5, 1.5)],
  edit_value: ["M4 16l1-4 8-8 3 3-8 8zM11.5 5.5l3 3"],
  rename: ["M2.5 6h15v8h-15z", "M6 8v4M4.8 8h2.4M4.8 12h2.4"],
  fit: ["M3 7V3h4M13 3h4v4M17 13v4h-4M7 17H3v-4", "M7 8h6v4h-6z"],
  zoom_in: [CIRCLE(8.5, 8.5, 5.5), "M12.5 12.5L17 17M6 8.5h5M8.5 6v5"],
  zoom_out: [CIRCLE(8.5, 8.5, 5.5), "M12.5 12.5L17 17M6 8.5h5"],
  grid: ["M3 3h14v14h-14zM3 7.7h14M3 12.3h14M7.7 3v14M12.3 3v14"],
  theme: [CIRCLE(10, 10, 7), "fM10 3a7 7 0 0 1 0 14z"],
  save: ["M3.5 3.5h10l3 3v10h-13zM6.5 3.5v4h6v-4M6 16.5v-5h8v5"],
  import: [PAGE, "M10 7.5v6M7.5 11l2.5 2.5 2.5-2.5"],
  export: [PAGE, "M10 13.5v-6M7.5 10L10 7.5l2.5 2.5"],
  keys: ["M2 5.5h16v9h-16zM5 8.5h.5M8 8.5h.5M11 8.5h.5M14 8.5h.5M6 11.5h8"],
  manual: ["M10 5c-2-1.5-5-1.5-7-1v11c2-.5 5-.5 7 1 2-1.5 5-1.5 7-1V4c-2-.5-5-.5-7 1zM10 5v11"],
  tour: [CIRCLE(10, 10, 7), "M13 7l-2 4-4 2 2-4z"],
  help: [CIRCLE(10, 10, 7.5), "M7.8 8a2.2 2.2 0 1 1 3.4 1.8c-.8.5-1.2.9-1.2 1.8M10 14.2v.3"],
  menu: ["M3 5.5h14M3 10h14M3 14.5h14"],
  // panels
  panel_selection: ["M4 3l7 5-3.5.6L6 12z", "M10 13h7M10 16.5h7M13 9.5h4"],
  panel_parameters: ["M3 5.5h9M16 5.5h1M3 10h2M9 10h8M3 14.5h7M14 14.5h3", CIRCLE(14, 5.5, 1.8), CIRCLE(7, 10, 1.8), CIRCLE(12, 14.5, 1.8)],
  panel_relations: ["M10 3v9M4 12h12M10 8.5h3.5V12M4 16.5h12"],
  panel_freedom: ["M10 2.5v15M2.5 10h15M8 4.5l2-2 2 2M15.5 8l2 2-2 2", DOT(10, 10, 1.8)],
  panel_history: [CIRCLE(10, 10, 7), "M10 5.5V10l3 2"],
  // signs
  close: ["M5 5l10 10M15 5L5 15"],
  add: ["M10 4v12M4 10h12"],
  more: ["fM12.5 17.5h5v-5z"],
  chevron: ["M6 8l4 4 4-4"],
  check: ["M4 10.5l4 4 8-9"],
  prompt: ["M5 5l5 5-5 5M11 15h5"],
  enter: ["M16 4v6H5M8 7l-3 3 3 3"],
  defined: [CIRCLE(10, 10, 7), "M6.5 10.2l2.4 2.4 4.6-5"],
  info: [CIRCLE(10, 10, 7.2), "M10 9v5M10 6.2v.3"],
  warning: ["M10 3L18 16.5H2zM10 8v4M10 14v.3"],
  error: ["M6.8 2.5h6.4l4.3 4.3v6.4l-4.3 4.3H6.8l-4.3-4.3V6.8zM10 6.5v4.5M10 13.4v.3"],
  agent: ["M5 7h10v8h-10zM10 3.5V7M8 10.5v1M12 10.5v1M2.5 10v3M17.5 10v3"],
};

const NAMESPACE = "http://www.w3.org/2000/svg";

/** Whether there is an icon. @param {string} name */
export function hasIcon(name) {
  return name in ICONS;
}

/**
 * An icon; a dot if there is none of that name.
 * @param {string} name
 * @returns {SVGSVGElement}
 */
export function icon(name) {
  const svg = document.createElementNS(NAMESPACE, "svg");
  svg.setAttribute("viewBox", "0 0 20 20");
  svg.setAttribute("class", "icon");
  svg.setAttribute("aria-hidden", "true");
  for (const path of ICONS[name] ?? [DOT(10, 10)]) {
    const element = document.createElementNS(NAMESPACE, "path");
    const filled = path.startsWith("f");
    element.setAttribute("d", filled ? path.slice(1) : path);
    if (filled) element.setAttribute("class", "filled");
    svg.append(element);
  }
  return svg;
}
