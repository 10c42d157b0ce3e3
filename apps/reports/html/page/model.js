'use strict';
// The model as the page holds it: texts of base64 become arrays, attributes become colours.

const reliefModel = (() => {
  // Viridis at nine places: its steps look equal, also to colour-blind readers.
  const RAMP = [[68, 1, 84], [71, 44, 122], [59, 81, 139], [44, 113, 142], [33, 144, 141], [39, 173, 129], [92, 200, 99],
    [170, 220, 50], [253, 231, 37]];
  const PLAIN = [196, 196, 192];
  const FILLED = [229, 124, 60];
  const UNKNOWN = [150, 152, 156];
  const NO_VIEW = 65535;

  function bytesOf(id) {
    const text = atob(document.getElementById(id).textContent);
    const bytes = new Uint8Array(text.length);
    for (let i = 0; i < text.length; ++i) bytes[i] = text.charCodeAt(i);
    return bytes;
  }

  // Positions about the middle of the model, whose longest side has length 1: all views of the scene look alike in every unit.
  function decodePositions(model) {
    const steps = new Uint16Array(bytesOf('viewer-positions').buffer);
    const positions = new Float32Array(steps.length);
    for (let i = 0; i < steps.length; ++i) {
      const extent = model.high[i % 3] - model.low[i % 3];
      positions[i] = (steps[i] / 65535 - 0.5) * extent / model.size;
    }
    return positions;
  }

  function ramp(part) {
    const place = Math.min(Math.max(part, 0), 1) * (RAMP.length - 1);
    const low = Math.min(Math.floor(place), RAMP.length - 2);
    return RAMP[low].map((c, k) => Math.round(c + (place - low) * (RAMP[low + 1][k] - c)));
  }

  // Colours that differ for neighbouring views: hues go round by the golden angle, in three shades.
  function viewColours(count) {
    return Array.from({length: count}, (_, i) => {
      const hue = i * 137.508 % 360, light = [0.55, 0.72, 0.4][i % 3], strong = 0.65 * Math.min(light, 1 - light);
      return [0, 8, 4].map(n => {
        const k = (n + hue / 30) % 12;
        return Math.round(255 * (light - strong * Math.max(-1, Math.min(k - 3, 9 - k, 1))));
      });
    });
  }

  function load() {
    const model = JSON.parse(document.getElementById('viewer-data').textContent);
    const extent = model.high.map((high, k) => high - model.low[k]);
    model.size = Math.max(...extent) || 1;
    model.middle = model.low.map((low, k) => (low + model.high[k]) / 2);
    model.positions = decodePositions(model);
    model.indices = new Uint32Array(bytesOf('viewer-faces').buffer);
    model.errors = bytesOf('viewer-errors');
    model.views = bytesOf('viewer-views');
    model.sourceViews = new Uint16Array(bytesOf('viewer-sources').buffer);
    model.filledVertices = bytesOf('viewer-filled');
    model.colourBytes = bytesOf('viewer-colours');
    return model;
  }

  // One colour per vertex, of three bytes each.
  function coloursBy(model, colourOf) {
    const colours = new Uint8Array(3 * model.vertices);
    for (let v = 0; v < model.vertices; ++v) colours.set(colourOf(v), 3 * v);
    return colours;
  }

  // From a table of 256 colours: far quicker than to mix each anew.
  function rampTable(most) {
    return Array.from({length: 256}, (_, byte) => ramp(byte / most));
  }

  const isFilled = (model, v) => model.filled && model.filledVertices[v] === 1;

  // The colourings that the attributes of the model allow: a name, a function that gives colours, and what the legend says.
  function colouringsOf(model) {
    const list = [{key: 'shaded', name: 'shaded', colours: () => coloursBy(model, () => PLAIN), legend: null}];
    if (model.error) {
      const table = rampTable(255);
      list.push({key: 'error', name: 'expected error',
        colours: () => coloursBy(model, v => isFilled(model, v) ? UNKNOWN : table[model.errors[v]]),
        legend: {title: 'Expected error', unit: model.unit, low: model.error[0], high: model.error[1], open: true,
          swatches: model.filled ? [[UNKNOWN, 'filled, not measured']] : []}});
    }
    if (model.filled)
      list.push({key: 'filled', name: 'filled',
        colours: () => coloursBy(model, v => isFilled(model, v) ? FILLED : PLAIN),
        legend: {title: 'Surface', swatches: [[PLAIN, 'measured'], [FILLED, 'filled, not measured']]}});
    if (model.views_most !== undefined) {
      const table = rampTable(Math.max(model.views_most, 1));
      list.push({key: 'views', name: 'number of views', colours: () => coloursBy(model, v => table[model.views[v]]),
        legend: {title: 'Views that measured a vertex', unit: 'views', low: 0, high: model.views_most, open: model.views_most === 255, swatches: []}});
    }
    if (model.sources) {
      const most = model.sourceViews.reduce((most, view) => view === NO_VIEW ? most : Math.max(most, view), 0);
      const table = viewColours(most + 1);
      const counts = new Uint32Array(most + 1);
      for (const view of model.sourceViews) if (view !== NO_VIEW) ++counts[view];
      list.push({key: 'source', name: 'source view',
        colours: () => coloursBy(model, v => model.sourceViews[v] === NO_VIEW ? UNKNOWN : table[model.sourceViews[v]]),
        legend: {title: 'View that counts most', swatches: [[UNKNOWN, 'filled, not measured']],
          views: [...counts.keys()].filter(view => counts[view] > 0).map(view =>
            [table[view], model.sources[view] || `view ${view}`, counts[view] / model.vertices])}});
    }
    if (model.colours)
      list.push({key: 'colour', name: 'colours of the scans', colours: () => model.colourBytes, legend: null});
    return list;
  }

  return {load, colouringsOf, ramp};
})();
