'use strict';
// What is drawn: the model, its inside where it is cut, the cameras of the views, and the measured points. Lengths are those
// of reliefModel: the longest side of the model is 1.

function createReliefScene(canvas, model) {
  // Smooth edges take two thirds of the time of a picture without a graphics card.
  const renderer = new THREE.WebGLRenderer({canvas, antialias: !drawsInSoftware(), alpha: true});
  renderer.setPixelRatio(Math.min(window.devicePixelRatio || 1, 2));
  renderer.localClippingEnabled = true;
  const scene = new THREE.Scene();
  const camera = new THREE.PerspectiveCamera(35, 1, 0.01, 200);
  const cut = new THREE.Plane(new THREE.Vector3(-1, 0, 0), 0);

  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.BufferAttribute(model.positions, 3));
  geometry.setIndex(new THREE.BufferAttribute(model.indices, 1));
  geometry.computeVertexNormals();
  const surface = new THREE.Mesh(geometry, surfaceMaterial());
  scene.add(surface, camera);
  // Lamps move with the eye: a model looks alike whichever of its axes is up.
  scene.add(new THREE.AmbientLight(0xffffff, 0.42));
  for (const [strength, ...place] of [[0.5, 0.4, 0.7, 1], [0.22, -0.9, -0.2, 0.6]]) {
    const lamp = new THREE.DirectionalLight(0xffffff, strength);
    lamp.position.set(...place);
    camera.add(lamp, lamp.target);
  }

  const cameras = new THREE.LineSegments(frustaOf(model), new THREE.LineBasicMaterial({color: 0x2f8de0}));
  cameras.visible = false;
  scene.add(cameras);
  const marks = new THREE.Group();
  scene.add(marks);

  camera.up.set(...model.up);
  const controls = new THREE.OrbitControls(camera, canvas);
  controls.enableKeys = false;  // They would pan; the page turns with them.

  function inScene(point) {
    return new THREE.Vector3(...point.map((p, k) => (p - model.middle[k]) / model.size));
  }

  function inWorld(vector) {
    return vector.toArray().map((p, k) => p * model.size + model.middle[k]);
  }

  function draw() {
    cancelAnimationFrame(drawing);
    drawing = 0;
    renderer.render(scene, camera);
  }

  let drawing = 0;
  function redraw() {
    if (!drawing) drawing = requestAnimationFrame(draw);
  }
  controls.addEventListener('change', redraw);

  // Takes the size of the room for the canvas; whether that changed.
  const size = [0, 0];
  function fit() {
    const {clientWidth, clientHeight} = canvas.parentElement;
    if (!clientWidth || !clientHeight || (clientWidth === size[0] && clientHeight === size[1])) return false;
    size.splice(0, 2, clientWidth, clientHeight);
    renderer.setSize(clientWidth, clientHeight, false);
    camera.aspect = clientWidth / clientHeight;
    camera.updateProjectionMatrix();
    return true;
  }
  function resize() {
    if (fit()) draw();
  }

  // As far away as all of the model fits into the picture.
  function distanceFor(radius) {
    const half = THREE.Math.degToRad(camera.fov / 2);
    return 1.05 * radius / Math.sin(Math.min(half, Math.atan(Math.tan(half) * camera.aspect)));
  }

  function lookFrom(direction, target, radius) {
    const away = direction.clone().normalize();
    if (away.lengthSq() < 0.5) away.set(1, -1, 0.5).normalize();
    controls.target.copy(target);
    camera.position.copy(target).addScaledVector(away, distanceFor(radius));
    controls.update();
    redraw();
  }

  function radiusOfModel() {
    geometry.computeBoundingSphere();
    return geometry.boundingSphere.radius;
  }

  function orbit(right, up) {
    const turn = new THREE.Quaternion().setFromUnitVectors(camera.up, new THREE.Vector3(0, 1, 0));
    const offset = camera.position.clone().sub(controls.target).applyQuaternion(turn);
    const place = new THREE.Spherical().setFromVector3(offset);
    place.theta += right;
    place.phi = Math.min(Math.max(place.phi - up, 0.02), Math.PI - 0.02);
    offset.setFromSpherical(place).applyQuaternion(turn.inverse());
    camera.position.copy(controls.target).add(offset);
    controls.update();
    redraw();
  }

  function zoom(factor) {
    camera.position.sub(controls.target).multiplyScalar(factor).add(controls.target);
    controls.update();
    redraw();
  }

  function pan(right, up) {
    const step = camera.position.distanceTo(controls.target);
    const move = new THREE.Vector3(right * step, up * step, 0).applyQuaternion(camera.quaternion);
    controls.target.add(move);
    camera.position.add(move);
    controls.update();
    redraw();
  }

  function colour(bytes) {
    geometry.setAttribute('color', new THREE.BufferAttribute(bytes, 3, true));
    redraw();
  }

  // Keeps what lies below `place` [unit] along the axis, or above; no axis: all.
  function section(axis, place, above) {
    const on = axis !== null;
    if (on) {
      const normal = [0, 0, 0];
      normal[axis] = above ? 1 : -1;
      cut.normal.set(...normal);
      cut.constant = -normal[axis] * (place - model.middle[axis]) / model.size;
    }
    if (!!surface.material.clippingPlanes !== on) surface.material.needsUpdate = true;
    surface.material.clippingPlanes = on ? [cut] : null;
    redraw();
  }

  // The nearest visible point of the surface at a place of the picture, from -1 to 1 right and up, in the frame of the scene.
  function pick(right, up) {
    const caster = new THREE.Raycaster();
    camera.updateMatrixWorld();
    caster.setFromCamera(new THREE.Vector2(right, up), camera);
    const clipped = surface.material.clippingPlanes !== null;
    const hits = caster.intersectObject(surface).filter(hit => !clipped || cut.distanceToPoint(hit.point) >= 0);
    if (hits.length === 0) return null;
    // What is seen of the inside is the cut: the point lies on it, not on the wall behind.
    const inside = hits[0].face.normal.dot(caster.ray.direction) > 0;
    const through = clipped && inside ? caster.ray.intersectPlane(cut, new THREE.Vector3()) : null;
    return through && through.distanceTo(caster.ray.origin) < hits[0].distance ? through : hits[0].point;
  }

  function mark(points) {
    marks.remove(...marks.children);
    const dot = new THREE.SphereBufferGeometry(0.008, 16, 12);
    for (const point of points) {
      const sphere = new THREE.Mesh(dot, new THREE.MeshBasicMaterial({color: 0xd61f69}));
      sphere.position.copy(point);
      marks.add(sphere);
    }
    if (points.length === 2) {
      const line = new THREE.BufferGeometry().setFromPoints(points);
      marks.add(new THREE.Line(line, new THREE.LineBasicMaterial({color: 0xd61f69, depthTest: false})));
    }
    redraw();
  }

  // Where a point [unit] appears, from -1 to 1 right and up.
  function project(point) {
    camera.updateMatrixWorld();
    const place = inScene(point).project(camera);
    return [place.x, place.y];
  }

  function showCameras(visible) {
    cameras.visible = visible;
    redraw();
  }

  return {inScene, inWorld, draw, redraw, fit, resize, lookFrom, radiusOfModel, orbit, zoom, pan, colour, section, pick, mark, project,
    showCameras, controls};
}

// Whether the processor draws, for want of a graphics card.
function drawsInSoftware() {
  const gl = document.createElement('canvas').getContext('webgl', {antialias: false});
  const names = gl && gl.getExtension('WEBGL_debug_renderer_info');
  const found = Boolean(names) && /swiftshader|llvmpipe|software|basic render/i.test(gl.getParameter(names.UNMASKED_RENDERER_WEBGL));
  if (gl) (gl.getExtension('WEBGL_lose_context') || {loseContext() {}}).loseContext();
  return found;
}

// Outside of the colours of the vertices; the inside, seen where the model is cut or open, of one colour without light. One
// drawing does both: to draw the faces twice takes twice the time without a graphics card.
function surfaceMaterial() {
  const material = new THREE.MeshPhongMaterial({vertexColors: THREE.VertexColors, shininess: 25, specular: 0x222222, side: THREE.DoubleSide});
  material.onBeforeCompile = shader => {
    const end = '#include <dithering_fragment>';
    shader.fragmentShader = shader.fragmentShader.replace(end, end + '\nif (!gl_FrontFacing) gl_FragColor = vec4(0.54, 0.353, 0.235, 1.0);');
  };
  return material;
}

// A pyramid from each camera's place to the corners of its picture.
function frustaOf(model) {
  const PART = 0.15;  // Of the distance to the model.
  const points = [];
  for (const view of model.cameras) {
    const pose = view.world_from_view;
    const corner = (x, y, z) => [0, 1, 2].map(k => pose[k][0] * x + pose[k][1] * y + pose[k][2] * z);
    const start = pose.slice(0, 3).map((row, k) => (row[3] - model.middle[k]) / model.size);
    const length = PART * Math.max(Math.hypot(...start), 0.8);
    const ends = [[view.left, view.top], [view.right, view.top], [view.right, view.bottom], [view.left, view.bottom]]
      .map(([x, y]) => corner(x * length, y * length, view.forward * length).map((p, k) => p + start[k]));
    for (let i = 0; i < 4; ++i) points.push(...start, ...ends[i], ...ends[i], ...ends[(i + 1) % 4]);
  }
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.BufferAttribute(new Float32Array(points), 3));
  return geometry;
}
