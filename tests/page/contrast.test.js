/** Contrast of text by WCAG 2.2 (relative luminance): at least 4.5:1, of edges and marks 3:1, in both themes. */

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";

const STYLES = new URL("../../arael/sketch/page/styles/", import.meta.url);
const read = (name) => readFileSync(new URL(name, STYLES), "utf8");

/** Colours of a style sheet: pairs of light and dark. */
const pairs = (file, prefix) =>
  Object.fromEntries(
    [...read(file).matchAll(/(--[a-z]+-[\w-]+): light-dark\((#\w{6}), (#\w{6})\)/g)]
      .filter(([, name]) => name.startsWith(prefix))
      .map(([, name, light, dark]) => [name, { light, dark }]),
  );
const tokens = pairs("tokens.css", "--ui-");
const drawing = pairs("canvas.css", "--sketch-");

/** Relative luminance of a colour. */
function luminance(hex) {
  const [r, g, b] = [1, 3, 5].map((i) => {
    const c = parseInt(hex.slice(i, i + 2), 16) / 255;
    return c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4;
  });
  return 0.2126 * r + 0.7152 * g + 0.0722 * b;
}

function contrast(a, b) {
  const [dark, light] = [luminance(a), luminance(b)].sort((x, y) => x - y);
  return (light + 0.05) / (dark + 0.05);
}

const TEXT = {
  "--ui-text": ["--ui-back", "--ui-raised", "--ui-sunken", "--ui-hover", "--ui-accent-back", "--ui-bad-back"],
  "--ui-soft": ["--ui-back", "--ui-raised", "--ui-sunken", "--ui-hover", "--ui-accent-back"],
  "--ui-accent": ["--ui-back", "--ui-raised", "--ui-hover", "--ui-accent-back"],
  "--ui-on-accent": ["--ui-accent"],
  "--ui-good": ["--ui-back", "--ui-raised"],
  "--ui-warn": ["--ui-back", "--ui-raised", "--ui-hover", "--ui-warn-back", "--ui-accent-back"],
  "--ui-bad": ["--ui-back", "--ui-raised", "--ui-hover", "--ui-bad-back", "--ui-accent-back"],
  "--ui-raised": ["--ui-bad"],
};

const DRAWN_TEXT = ["dimension", "derived", "note", "label"];
const DRAWN_MARKS = ["free", "defined", "redundant", "impossible", "selected", "construction", "preview", "snap", "glyph"];

for (const theme of ["light", "dark"]) {
  test(`text of the interface can be read, ${theme}`, () => {
    for (const [text, grounds] of Object.entries(TEXT)) {
      for (const ground of grounds) {
        const found = contrast(tokens[text][theme], tokens[ground][theme]);
        assert.ok(found >= 4.5, `${text} on ${ground}: ${found.toFixed(2)}`);
      }
    }
  });

  test(`edges of fields are seen, ${theme}`, () => {
    for (const ground of ["--ui-back", "--ui-raised"]) {
      const found = contrast(tokens["--ui-edge"][theme], tokens[ground][theme]);
      assert.ok(found >= 3, `--ui-edge on ${ground}: ${found.toFixed(2)}`);
    }
  });

  test(`the drawing can be read, ${theme}`, () => {
    for (const name of DRAWN_TEXT) {
      const ground = name === "label" ? "--sketch-label-back" : "--sketch-background";
      const found = contrast(drawing[`--sketch-${name}`][theme], drawing[ground][theme]);
      assert.ok(found >= 4.5, `${name}: ${found.toFixed(2)}`);
    }
    for (const name of DRAWN_MARKS) {
      const found = contrast(drawing[`--sketch-${name}`][theme], drawing["--sketch-background"][theme]);
      assert.ok(found >= 3, `${name}: ${found.toFixed(2)}`);
    }
  });
}

test("each colour of the drawing stands once, with its dark one", () => {
  const names = [...read("canvas.css").matchAll(/^\s*(--sketch-[\w-]+):/gm)].map(([, name]) => name);
  assert.deepEqual(names, Object.keys(drawing));
});
