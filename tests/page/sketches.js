/** Small documents for tests of the page, as the server would send them. */

import { Store } from "../../arael/sketch/page/store.js";
import { View } from "../../arael/sketch/page/view.js";
import { Picker } from "../../arael/sketch/page/pick.js";
import { Snapper } from "../../arael/sketch/page/snap/snapper.js";

/** A store with entities `[name, kind, numbers, more]` and constraints `[name, kind, args]`. */
export function stored(entities, constraints = [], dimensions = []) {
  const store = new Store();
  const values = [];
  const records = entities.map(([name, kind, numbers, more = {}]) => {
    const record = { name, kind, at: values.length, size: numbers.length, ...more };
    values.push(...numbers);
    return record;
  });
  store.receive({
    type: "snapshot", revision: 7, values,
    document: {
      entities: records,
      constraints: constraints.map(([name, kind, args]) => ({ name, kind, args })),
      dimensions, parameters: [], groups: [],
    },
  });
  return store;
}

/** A view of 800 by 600 pixels, ten to a unit, the origin in the middle. */
export function viewed() {
  const view = new View();
  view.resize(800, 600);
  view.scale = 10;
  view.centre([0, 0]);
  view.grid = false;
  return view;
}

/** Store, view, picker and snapper of a document. */
export function scene(entities, constraints) {
  const store = stored(entities, constraints);
  const view = viewed();
  const picker = new Picker(store, view);
  return { store, view, picker, snapper: new Snapper(store, view, picker) };
}
