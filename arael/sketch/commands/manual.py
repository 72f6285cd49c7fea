"""The manual of commands, made from their table."""

from __future__ import annotations

from types import MappingProxyType

from arael.sketch.commands import table
from arael.sketch.commands.table import GROUPS, Command
from arael.sketch.expressions.functions import GEOMETRY, scalar_functions

_LANGUAGE = """
A line holds one command or several with `;` between them. It is one step of undo: if a command of
it fails, nothing of the line is done. `#` begins a comment. Text in double quotes is one word.

Lengths are in the sketch's unit (millimetres unless set otherwise), angles in degrees,
counter-clockwise. x points to the right, y upwards.
"""

_NAMES = """
| name | what |
|---|---|
| `L0` `A0` `EA0` `P0` `S0` | lines, circles and arcs, ellipses and elliptic arcs, points, splines |
| `L0.p1` `L0.p2` | ends of a line or spline |
| `A0.center` `A0.start` `A0.end` | points of circles, arcs, ellipses |
| `S0.pole1` ... | poles of a spline |
| `C3` `CL0H` `CL0V` | constraints; the last two: L0 is horizontal, vertical |
| `d0` | dimensions |
| `M0` | groups: offsets, patterns, slots, polygons, texts |

Names stay what they are when a sketch is saved and loaded, and when commands are undone.
"""

_COORDINATES = """
| form | example | meaning |
|---|---|---|
| `x,y` | `5,3` | a place; each part may be an expression: `width/2,L0.length` |
| `@dx,dy` | `@0,3` | from the coordinate before in the same command, else from the cursor |
| `cursor`, `@cursor` | `add_point cursor` | the cursor |
| `@tangent` | `add_earc_tangent @cursor @tangent 10,3 0,1` | the direction at the cursor |
| a point | `L0.p2` | where it is now |
| a variable | `p` | set by `p = L0.p2` |
| a function | `midpoint(L0)` | see expressions |
| arithmetic | `L0.p2 + normal(L0)*3` | sums of coordinates, products with numbers |
"""

_EXPRESSIONS = """
Wherever a number is expected an expression can stand: `+ - * / ^`, brackets, functions,
`(if a > b then x else y)`. It reads:

- parameters: `width`
- values of dimensions: `d0`
- properties: `L0.length L0.angle L0.p1.x`, `A0.radius A0.diameter A0.sweep A0.length A0.start_angle
  A0.end_angle A0.center.x`, `EA0.radius EA0.radius_b EA0.rotation EA0.length`,
  `S0.length S0.pole2.x`, `P0.x P0.y`
- variables: `n`, `p.x`
- literals with a unit: `12 mm`, `0.5 in`, `30 deg`; units are `um mm cm m in ft deg rad`

Angles are in degrees. `sin`, `cos` and `tan` take an angle (`30 deg`, `L0.angle`) as what it is and
a plain number as radians; inverse functions give radians: `atan2(3, 4) * 1 rad` is an angle.

An expression that is the value of a dimension or a parameter is live: it follows what it reads.
With `=` before it, it is worked out once.
"""

_VARIABLES = """
```
base = add_line 0,0 5,0            # the name of what a command made
a, b = split L0 by L1              # several names
p = L0.p2 + normal(L0)*2           # a coordinate; p.x and p.y are its parts
n = dist(P0, L1)                   # a number
let n = 5                          # the same with `let`
```

`_` is what the last command made, `_0`, `_1`, ... each of several. A variable that holds a name can
be written wherever the name can: `length base 3`, `coincident base.p2 side.p1`, `base.length`.
Dimensions that read a variable keep what it is now.
"""

_USE = """
- `arael sketch` opens a prompt; `arael sketch part.cmd` runs a script; `--export part.dxf` writes
  the result.
- In Python every command is a method of `Sketch`, with the same words:

```python
from arael.sketch import Sketch

sketch = Sketch()
sketch.param("w", 10)
bottom, right, top, left = sketch.add_rect((0, 0), (9, 4), hv=True)
sketch.length(bottom, "w")
sketch.length(right, "w/2")
hole = sketch.add_circle((5, 2), 1)
sketch.distance(hole.center, bottom, ">= 2")
sketch.run("lock L0.p1 0,0")
print(f"{bottom.length:.3f} x {right.length:.3f}, {sketch.dof()['freedoms']} degrees of freedom")
```

```text
10.000 x 5.000, 3 degrees of freedom
```
"""

TOPICS = MappingProxyType(
    {
        "use": ("Use", _USE),
        "language": ("Command lines", _LANGUAGE),
        "names": ("Names", _NAMES),
        "coordinates": ("Coordinates", _COORDINATES),
        "expressions": ("Expressions", _EXPRESSIONS),
        "functions": ("Functions", ""),
        "variables": ("Variables", _VARIABLES),
    }
)


def summary() -> str:
    """All commands, a line each."""
    parts = []
    for group, title in GROUPS.items():
        found = [one for one in table.commands().values() if one.group == group]
        if not found:
            continue
        width = max(len(one.name) for one in found)
        lines = [f"  {one.name:<{width}}  {one.summary}" for one in found]
        parts.append("\n".join([f"{title}:", *lines]))
    topics = ", ".join(TOPICS)
    parts.append(f"`help COMMAND` says more; topics: {topics}; `help full` is the whole manual.")
    return "\n\n".join(parts)


def of_command(command: Command) -> str:
    """The help of one command."""
    lines = [f"{command.name}: {command.summary}", ""]
    lines += [f"  {line}" for line in command.usage]
    if command.aliases:
        lines += ["", f"Also: {', '.join(command.aliases)}"]
    if command.details.strip():
        lines += ["", command.details.strip()]
    return "\n".join(lines)


def of_topic(topic: str) -> str:
    """The help of a topic, or of a group of commands."""
    if topic in TOPICS:
        title, text = TOPICS[topic]
        return f"{title}\n\n{(text or _functions()).strip()}"
    found = [one for one in table.commands().values() if one.group == topic]
    return "\n\n".join([f"{GROUPS[topic]}:", *map(of_command, found)])


def _functions() -> str:
    """Tables of the functions."""
    geometry = ["| function | gives | meaning |", "|---|---|---|"]
    geometry += [f"| `{one.example}` | {one.gives} | {one.meaning} |" for one in GEOMETRY.values()]
    numbers = ["| function | meaning |", "|---|---|"]
    numbers += [f"| `{name}` | {one.meaning} |" for name, one in scalar_functions().items()]
    numbers.append("| `pi` | 3.14159... |")
    note = "`dist` and `angle` can be followed by live expressions, the others by `=` only."
    return "\n".join(
        ["Of points and curves:", "", *geometry, "", note, "", "Of numbers:", "", *numbers]
    )


def full() -> str:
    """The whole manual as Markdown."""
    parts = ["# Commands of the sketch editor"]
    for title, text in TOPICS.values():
        parts.append(f"## {title}\n\n{(text or _functions()).strip()}")
    for group, title in GROUPS.items():
        found = [one for one in table.commands().values() if one.group == group]
        if found:
            parts.append(f"## {title}")
            parts += [_section(one) for one in found]
    return "\n\n".join(parts) + "\n"


def _section(command: Command) -> str:
    lines = [f"### {command.name}", "", command.summary, "", "```", *command.usage, "```"]
    if command.aliases:
        lines += ["", f"Also: {', '.join(f'`{one}`' for one in command.aliases)}."]
    if command.details.strip():
        lines += ["", command.details.strip()]
    return "\n".join(lines)
