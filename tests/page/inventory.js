/** Everything that a person can use on the page, as JSON `{part: title}`: `node tests/page/inventory.js`. */

import { allActions } from "../../arael/sketch/page/actions.js";
import { FORMATS } from "../../arael/sketch/page/actions/filing.js";
import { PANELS } from "../../arael/sketch/page/actions/viewing.js";
import { DRAWING, POINTER } from "../../arael/sketch/page/help.js";
import { RANKS } from "../../arael/sketch/page/snap/snapper.js";
import { TOOLS } from "../../arael/sketch/page/tools/index.js";

const actions = allActions(TOOLS);
const parts = [
  ...TOOLS.map(({ id, title }) => [`tool:${id}`, title]),
  ...actions.filter(({ group }) => group !== "tool").map(({ id, title }) => [`action:${id}`, title]),
  ...actions.flatMap((one) => [one.key, ...(one.also ?? [])].filter(Boolean).map((key) => [`key:${key}`, one.title])),
  ...Object.keys(RANKS).map((kind) => [`snap:${kind}`, kind]),
  ...PANELS.map(({ id, title }) => [`panel:${id}`, title]),
  ...FORMATS.map(({ id, title }) => [`export:${id}`, title]),
  ...FORMATS.filter(({ reads }) => reads).map(({ id, title }) => [`import:${id}`, title]),
  ...[...POINTER, ...DRAWING].map(({ key, title }) => [`pointer:${key}`, title]),
];
process.stdout.write(JSON.stringify(parts));
