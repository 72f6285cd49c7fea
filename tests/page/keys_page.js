/** Writes docs/sketch_keys.md from the table of actions: `node tests/page/keys_page.js`. */

import { GROUPS, allActions } from "../../arael/sketch/page/actions.js";
import { DRAWING, POINTER } from "../../arael/sketch/page/help.js";
import { TOOLS } from "../../arael/sketch/page/tools/index.js";

const HEAD = `# Keys and tools of the sketch editor

Every key acts on the drawing or on what is selected; none needs the pointer. \`?\` shows this list in the editor, with a
search; a click on a line there runs it. On a Mac the Command key stands for Ctrl.
[The first part](sketch_first_part.md) shows the editor, [Commands](sketch_commands.md) what each step writes.
`;

const NOTES = {
  tool: "A tool stays until another one is chosen or Escape is pressed. Tools of one family share a button; the others open from its corner.",
  constrain:
    "They act on the selection. If it does not fit, what is needed is picked after the key.",
  dimension: "They act on the selection, or what is needed is picked after the key; the value is typed over the drawing, the one that it has now is offered.",
};

const code = (/** @type {string} */ key) => (key === "|" ? "`\\|`" : `\`${key}\``);

/** @param {string[]} heads @param {string[][]} rows */
function table(heads, rows) {
  const line = (/** @type {string[]} */ cells) => `| ${cells.join(" | ")} |`;
  return [line(heads), `|${"---|".repeat(heads.length)}`, ...rows.map(line)].join("\n");
}

const hints = new Map(TOOLS.map((tool) => [`tool_${tool.id}`, tool.hint]));
const actions = allActions(TOOLS);

/** @param {string} group */
function section(group) {
  const found = actions.filter((one) => one.group === group);
  const keys = (/** @type {import("../../arael/sketch/page/actions.js").Action} */ one) =>
    [one.key, ...(one.also ?? [])].filter(Boolean).map(code).join(", ");
  if (group === "tool") {
    return table(
      ["Key", "Tool", "How"],
      found.map((one) => [keys(one), one.title, hints.get(one.id) ?? ""]),
    );
  }
  const needs = found.some((one) => one.needs);
  const rows = found.map((one) => [keys(one), one.title, ...(needs ? [one.needs ?? ""] : [])]);
  return table(["Key", "Action", ...(needs ? ["Needs"] : [])], rows);
}

const parts = Object.entries(GROUPS).map(([group, title]) => {
  const note = /** @type {Record<string, string>} */ (NOTES)[group];
  return `\n## ${title}\n\n${note ? `${note}\n\n` : ""}${section(group)}\n`;
});
const pointer = table(
  ["What", "Does"],
  [...POINTER, ...DRAWING].map(({ key, title }) => [key, title]),
);
process.stdout.write(`${HEAD}\n## Drawing\n\n${pointer}\n${parts.join("")}`);
