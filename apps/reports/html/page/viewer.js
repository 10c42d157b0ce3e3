'use strict';
// The controls of the viewer. All of them work with the keyboard alone.

(() => {
  const byId = id => document.getElementById(id);
  const canvas = byId('canvas');

  function giveUp(reason) {
    const message = document.querySelector('#viewer > .no-viewer');
    message.textContent = 'The model cannot be drawn here: ' + reason + ' All else on this page can be read without.';
    message.hidden = false;
    document.querySelector('#viewer .viewer').hidden = true;
    for (const button of document.querySelectorAll('.show')) button.hidden = true;
  }

  const model = reliefModel.load();
  let view;
  try {
    view = createReliefScene(canvas, model);
  } catch (error) {
    giveUp('this browser has no WebGL.');
    return;
  }
  canvas.addEventListener('webglcontextlost', () => giveUp('the graphics system stopped.'));

  const number = value => Number(value.toPrecision(4)).toString();
  const short = value => Number(value.toPrecision(3)).toString();
  const css = colour => `rgb(${colour.join(',')})`;

  function element(tag, properties, ...children) {
    const made = Object.assign(document.createElement(tag), properties);
    made.append(...children);
    return made;
  }

  function rampStyle() {
    const stops = Array.from({length: 9}, (_, i) => css(reliefModel.ramp(i / 8)));
    return `linear-gradient(90deg, ${stops.join(', ')})`;
  }

  // Below the model: names of views need room.
  function showViews(views) {
    const list = byId('view-key');
    list.hidden = !views;
    list.replaceChildren(...(views || []).map(([colour, name, share]) => {
      const swatch = element('span', {className: 'swatch'});
      swatch.style.background = css(colour);
      return element('li', {}, swatch, `${name} (${short(100 * share)}\u202f%)`);
    }));
  }

  function showLegend(legend) {
    const box = byId('legend');
    box.replaceChildren();
    showViews(legend && legend.views);
    if (!legend) return;
    const unit = legend.unit && legend.unit !== 'views' ? ` [${legend.unit}]` : '';
    box.append(element('div', {textContent: legend.title + unit}));
    if (legend.low !== undefined) {
      const ramp = element('div', {className: 'ramp'});
      ramp.style.background = rampStyle();
      box.append(ramp, element('div', {className: 'ends'}, element('span', {textContent: (legend.open && legend.low > 0 ? '≤ ' : '') + short(legend.low)}),
        element('span', {textContent: (legend.open ? '≥ ' : '') + short(legend.high)})));
    }
    for (const [colour, text] of legend.swatches) {
      const swatch = element('span', {className: 'swatch'});
      swatch.style.background = css(colour);
      box.append(element('div', {}, swatch, text));
    }
  }

  const colourings = reliefModel.colouringsOf(model);
  for (const colouring of colourings) byId('colouring').append(new Option(colouring.name, colouring.key));
  function setColouring() {
    const chosen = colourings.find(colouring => colouring.key === byId('colouring').value);
    view.colour(chosen.colours());
    showLegend(chosen.legend);
  }
  byId('colouring').addEventListener('change', setColouring);

  const centre = new THREE.Vector3();
  const directionOf = camera => view.inScene(camera.world_from_view.slice(0, 3).map(row => row[3]));
  const first = new THREE.Vector3(...model.towards_viewer);
  function whole() {
    view.lookFrom(first, centre, view.radiusOfModel());
    byId('look-from').value = '';
  }
  byId('look-from').append(new Option('any side', ''));
  model.cameras.forEach((camera, i) => byId('look-from').append(new Option(camera.name, i)));
  byId('look-from').addEventListener('change', event => {
    if (event.target.value === '') whole();
    else view.lookFrom(directionOf(model.cameras[event.target.value]), centre, view.radiusOfModel());
  });
  byId('whole').addEventListener('click', whole);
  byId('cameras').disabled = model.cameras.length === 0;
  byId('cameras').addEventListener('change', event => {
    view.showCameras(event.target.checked);
    if (event.target.checked) {
      const far = Math.max(...model.cameras.map(camera => directionOf(camera).length()));
      const offset = view.controls.object.position.clone().sub(view.controls.target);
      view.lookFrom(offset, centre, Math.max(far + 0.15, view.radiusOfModel()));
    }
  });

  function setSection() {
    const axis = byId('section-axis').value === '' ? null : Number(byId('section-axis').value);
    byId('section-place').disabled = byId('section-side').disabled = axis === null;
    byId('section-value').textContent = '';
    if (axis === null) return view.section(null, 0, false);
    const place = model.low[axis] + byId('section-place').value / 1000 * (model.high[axis] - model.low[axis]);
    byId('section-value').textContent = `${number(place)} ${model.unit}`;
    view.section(axis, place, byId('section-side').checked);
  }
  for (const id of ['section-axis', 'section-place', 'section-side']) byId(id).addEventListener('input', setSection);

  let picked = [];
  function showMeasured() {
    const box = byId('measured');
    box.dataset.distance = '';
    if (!byId('measure').checked) {
      box.textContent = '';
    } else if (picked.length < 2) {
      box.textContent = picked.length === 0 ? 'Pick the first point on the model.' : 'Pick the second point.';
    } else {
      const distance = picked[0].distanceTo(picked[1]) * model.size;
      box.dataset.distance = distance;
      const points = picked.map(point => '(' + view.inWorld(point).map(number).join(', ') + ')');
      box.textContent = `Distance: ${number(distance)} ${model.unit}, from ${points[0]} to ${points[1]}.`;
    }
  }
  function pickAt(right, up) {
    const point = view.pick(right, up);
    if (!point) {
      byId('measured').textContent = 'The model is not there. Pick a point on it.';
      return;
    }
    picked = picked.length < 2 ? [...picked, point] : [point];
    view.mark(picked);
    showMeasured();
  }
  function setMeasuring() {
    const on = byId('measure').checked;
    picked = [];
    view.mark(picked);
    byId('cross').hidden = byId('pick-centre').disabled = !on;
    byId('cross').hidden = !on;
    canvas.classList.toggle('measuring', on);
    showMeasured();
  }
  byId('measure').addEventListener('change', setMeasuring);
  byId('pick-centre').addEventListener('click', () => pickAt(0, 0));

  // A press that does not move picks; one that moves turns the model.
  let pressed = null;
  canvas.addEventListener('pointerdown', event => { pressed = event.isPrimary ? [event.clientX, event.clientY] : null; });
  canvas.addEventListener('pointerup', event => {
    const still = pressed && Math.hypot(event.clientX - pressed[0], event.clientY - pressed[1]) < 5;
    if (!still || event.button !== 0 || !byId('measure').checked) return;
    const box = canvas.getBoundingClientRect();
    pickAt((event.clientX - box.left) / box.width * 2 - 1, 1 - (event.clientY - box.top) / box.height * 2);
  });

  // The wheel scrolls the page until the model is chosen by a click or by the keyboard.
  view.controls.enableZoom = false;
  canvas.addEventListener('focus', () => { view.controls.enableZoom = true; });
  canvas.addEventListener('blur', () => { view.controls.enableZoom = false; });
  canvas.addEventListener('touchstart', () => canvas.focus({preventScroll: true}), {capture: true, passive: true});

  const STEP = Math.PI / 24;
  const PAN = 0.04;
  const keys = {
    ArrowLeft: shift => shift ? view.pan(PAN, 0) : view.orbit(-STEP, 0),
    ArrowRight: shift => shift ? view.pan(-PAN, 0) : view.orbit(STEP, 0),
    ArrowUp: shift => shift ? view.pan(0, -PAN) : view.orbit(0, STEP),
    ArrowDown: shift => shift ? view.pan(0, PAN) : view.orbit(0, -STEP),
    '+': () => view.zoom(0.85), '=': () => view.zoom(0.85), '-': () => view.zoom(1 / 0.85), '0': whole,
    m: () => { byId('measure').checked = !byId('measure').checked; setMeasuring(); },
    Enter: () => { if (byId('measure').checked) pickAt(0, 0); },
  };
  canvas.addEventListener('keydown', event => {
    const action = keys[event.key];
    if (!action || event.ctrlKey || event.altKey || event.metaKey) return;
    event.preventDefault();
    action(event.shiftKey);
  });
  byId('controls').addEventListener('submit', event => event.preventDefault());

  for (const button of document.querySelectorAll('.show'))
    button.addEventListener('click', () => {
      const numbers = text => text.split(' ').map(Number);
      byId('colouring').value = 'filled';
      setColouring();
      view.lookFrom(new THREE.Vector3(...numbers(button.dataset.outward)), view.inScene(numbers(button.dataset.centre)), 0.45);
      byId('viewer').scrollIntoView();
      canvas.focus({preventScroll: true});
    });

  const count = value => value.toLocaleString('en');
  byId('hint').textContent = `Drag turns, wheel or pinch zooms, the right button or two fingers move. Keys: arrows turn, with Shift they move, + and − zoom, 0 shows all, M measures, Enter picks at the cross. ` +
    (model.faces < model.faces_before ? `Shown are ${count(model.faces)} of ${count(model.faces_before)} faces.` : `All ${count(model.faces)} faces are shown.`);
  view.fit();
  whole();
  setColouring();
  setMeasuring();
  view.draw();
  new ResizeObserver(view.resize).observe(canvas.parentElement);
  // For consoles and tests. When the second frame begins, the first one is on the screen.
  window.reliefViewer = {model, draw: view.draw, project: view.project, firstPicture: null};
  requestAnimationFrame(() => requestAnimationFrame(() => { window.reliefViewer.firstPicture = performance.now(); }));
})();
