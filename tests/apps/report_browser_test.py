#!/usr/bin/env python3
"""Opens a report.html in Chromium and uses it: usage: report_browser_test.py RELIEF

The model is a box of known size. Ends with status 77, which CTest shows as skipped, where there is no Chromium. The
browser is driven through its DevTools protocol over two pipes, so that no further package is needed.
"""

import json
import math
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time

SKIPPED = 77
SIZE = (40.0, 30.0, 20.0)  # Of the box [mm].
CENTRE = (100.0, -50.0, 7.0)
DIVISIONS = 24  # Of each side.
ARGUMENTS = ["--headless=new", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
             "--remote-debugging-pipe", "--no-first-run", "--hide-scrollbars", "--force-color-profile=srgb"]


class Browser:
    """A page of a headless Chromium. Messages are JSON that ends with a zero byte."""

    def __init__(self, program, profile, extra=()):
        to_browser, self.out = os.pipe()
        self.inp, from_browser = os.pipe()
        shell = f'exec "$0" "$@" 3<&{to_browser} 4>&{from_browser}'  # The pipes must be files 3 and 4.
        self.process = subprocess.Popen(
            ["bash", "-c", shell, program, *ARGUMENTS, *extra, f"--user-data-dir={profile}", "about:blank"],
            pass_fds=[to_browser, from_browser], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(to_browser)
        os.close(from_browser)
        self.buffer, self.number, self.session, self.faults = b"", 0, None, []
        target = next(t for t in self.wait_for_targets() if t["type"] == "page")
        self.session = self.call("Target.attachToTarget", targetId=target["targetId"], flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log"):
            self.call(domain + ".enable")

    def wait_for_targets(self):
        for _ in range(100):
            targets = self.call("Target.getTargets")["targetInfos"]
            if any(t["type"] == "page" for t in targets):
                return targets
            time.sleep(0.1)
        raise RuntimeError("Chromium opened no page")

    def call(self, method, **parameters):
        self.number += 1
        message = {"id": self.number, "method": method, "params": parameters}
        if self.session:
            message["sessionId"] = self.session
        os.write(self.out, json.dumps(message).encode() + b"\0")
        while True:
            answer = self.receive()
            if answer.get("id") == self.number:
                if "error" in answer:
                    raise RuntimeError(f"{method}: {answer['error']}")
                return answer["result"]

    def receive(self):
        while b"\0" not in self.buffer:
            part = os.read(self.inp, 1 << 20)
            if not part:
                raise RuntimeError("Chromium ended")
            self.buffer += part
        text, _, self.buffer = self.buffer.partition(b"\0")
        message = json.loads(text)
        self.note_fault(message)
        return message

    def note_fault(self, message):
        method, params = message.get("method"), message.get("params", {})
        if method == "Runtime.exceptionThrown":
            self.faults.append(params["exceptionDetails"].get("exception", {}).get("description", "exception"))
        elif method == "Runtime.consoleAPICalled" and params["type"] in ("error", "assert"):
            self.faults.append(str([a.get("value") for a in params["args"]]))
        elif method == "Log.entryAdded" and params["entry"]["level"] == "error":
            self.faults.append(params["entry"]["text"])

    def evaluate(self, expression):
        result = self.call("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in result:
            raise RuntimeError(f"{expression}: {result['exceptionDetails']}")
        return result["result"].get("value")

    def open(self, path, width, height, phone=False):
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=phone)
        self.call("Emulation.setTouchEmulationEnabled", enabled=phone)
        self.call("Page.navigate", url=path.as_uri())
        for _ in range(600):
            if self.evaluate("document.readyState") == "complete" and self.evaluate("location.protocol") == "file:":
                return
            time.sleep(0.05)
        raise RuntimeError("the page does not load")

    def mouse(self, kind, x, y, **more):
        self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", clickCount=1, **more)

    def click(self, x, y):
        self.mouse("mousePressed", x, y, buttons=1)
        self.mouse("mouseReleased", x, y)

    def key(self, key, code=0, text="", modifiers=0):
        kind = "keyDown" if text else "rawKeyDown"
        self.call("Input.dispatchKeyEvent", type=kind, key=key, windowsVirtualKeyCode=code, text=text, modifiers=modifiers)
        self.call("Input.dispatchKeyEvent", type="keyUp", key=key, windowsVirtualKeyCode=code, modifiers=modifiers)

    def close(self):
        self.process.terminate()
        self.process.wait(20)


# A copy of the canvas right after it was drawn: every pixel of a coarse grid, as one number each.
PIXELS = """(() => {
  reliefViewer.draw();
  const canvas = document.getElementById('canvas'), copy = document.createElement('canvas');
  [copy.width, copy.height] = [80, 60];
  const context = copy.getContext('2d');
  context.drawImage(canvas, 0, 0, 80, 60);
  const bytes = context.getImageData(0, 0, 80, 60).data, pixels = [];
  for (let i = 0; i < bytes.length; i += 4) pixels.push([bytes[i], bytes[i + 1], bytes[i + 2], bytes[i + 3]]);
  return pixels;
})()"""


def side_points(axis, sign):
    """A side of the box as a grid of points and of two triangles a cell, seen counter-clockwise from outside."""
    u, v = ((axis + 1) % 3, (axis + 2) % 3)
    points, faces, row = [], [], DIVISIONS + 1
    for i in range(row):
        for j in range(row):
            point = [0.0] * 3
            point[axis] = sign * SIZE[axis] / 2
            point[u] = (i / DIVISIONS - 0.5) * SIZE[u]
            point[v] = (j / DIVISIONS - 0.5) * SIZE[v]
            points.append(tuple(point))
    for i in range(DIVISIONS):
        for j in range(DIVISIONS):
            a, b, c, d = i * row + j, (i + 1) * row + j, (i + 1) * row + j + 1, i * row + j + 1
            quad = (a, b, c, d) if sign > 0 else (a, d, c, b)
            faces += [(quad[0], quad[1], quad[2]), (quad[0], quad[2], quad[3])]
    return points, faces


def box():
    places, vertices, faces = {}, [], []
    for axis in range(3):
        for sign in (-1, 1):
            points, side = side_points(axis, sign)
            indices = []
            for point in points:
                key = tuple(round(p, 6) for p in point)
                if key not in places:
                    places[key] = len(vertices)
                    vertices.append(key)
                indices.append(places[key])
            faces += [tuple(indices[k] for k in face) for face in side]
    return vertices, faces


def write_model(path):
    vertices, faces = box()
    lines = ["ply", "format ascii 1.0", f"element vertex {len(vertices)}", "property float x", "property float y",
             "property float z", "property float quality", "property ushort views", "property ushort source_view",
             "property uchar filled",
             f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header"]
    for x, y, z in vertices:
        filled = z > 9 and x > 0
        place = [p + c for p, c in zip((x, y, z), CENTRE)]
        lines.append(f"{place[0]} {place[1]} {place[2]} {0.01 + 0.001 * (x + 20)} {0 if filled else 1 + int(y > 0)} "
                     f"{65535 if filled else int(x > 0)} {int(filled)}")
    lines += ["3 " + " ".join(map(str, face)) for face in faces]
    path.write_text("\n".join(lines) + "\n")
    return len(vertices), len(faces)


def looking_from(direction, distance):
    """Pose of a camera that looks at the centre: columns x right, y down, z forward."""
    norm = math.sqrt(sum(d * d for d in direction))
    away = [d / norm for d in direction]
    forward = [-a for a in away]
    up = [0.0, 0.0, 1.0] if abs(away[2]) < 0.9 else [0.0, 1.0, 0.0]
    right = [forward[1] * up[2] - forward[2] * up[1], forward[2] * up[0] - forward[0] * up[2],
             forward[0] * up[1] - forward[1] * up[0]]
    length = math.sqrt(sum(r * r for r in right))
    right = [r / length for r in right]
    down = [forward[1] * right[2] - forward[2] * right[1], forward[2] * right[0] - forward[0] * right[2],
            forward[0] * right[1] - forward[1] * right[0]]
    rows = [[right[k], down[k], forward[k], CENTRE[k] + distance * away[k]] for k in range(3)]
    return rows + [[0.0, 0.0, 0.0, 1.0]]


def write_run(folder):
    count, faces = write_model(folder / "model.ply")
    hostile = "</script><img src=x onerror=console.error('escaped')>\"'&"
    views = [{"name": "front", "world_from_view": looking_from((0, -1, 0.2), 200), "aligned": True, "status": "verified", "pose_std": [0] * 6},
             {"name": hostile, "world_from_view": looking_from((1, 0.4, 0.5), 200), "aligned": True, "status": "verified", "pose_std": [1e-4] * 6}]
    pair = {"a": "front", "b": hostile, "overlap": 0.4, "rms": 0.012, "correspondences": 900, "grade": "firm", "degenerate_directions": []}
    loop = {"views": ["front", hostile, "front"], "length": 0.021, "length_std": 0.02, "angle_deg": 0.01, "angle_std_deg": 0.012, "ratio": 1.05}
    bands = [{"wavelength": 2.0 ** k, "measured": 0.1, "refined": 0.1 - 0.09 / k} for k in range(1, 8)]
    refine = {"views": [{"name": view["name"], "status": "refined", "sigma_position": 0.1, "spectrum": bands} for view in views]}
    align = {"termination": "converged", "iterations": 4, "rms": 0.012, "views": views, "pairs": [pair], "loops": [loop], "seconds": 1.0}
    merge = {"vertices": count, "faces": faces, "watertight": True, "volume": SIZE[0] * SIZE[1] * SIZE[2], "filled_area_fraction": 0.1}
    (folder / "report.json").write_text(json.dumps({"relief": "0", "align": align, "refine": refine, "merge": merge}))
    camera = {"model": "pinhole", "width": 100, "height": 80, "fx": 200, "fy": 200, "cx": 49.5, "cy": 39.5}
    scans = [{"name": view["name"], "camera": camera, "world_from_view": view["world_from_view"]} for view in views]
    (folder / "scan.json").write_text(json.dumps({"format": "relief-scan", "version": 1, "unit": "mm", "views": scans}))
    return faces


def check(condition, what):
    print(("ok      " if condition else "FAILED  ") + what, flush=True)
    check.failed = check.failed or not condition


check.failed = False


def differing(before, after):
    return sum(sum(abs(a - b) for a, b in zip(p, q)) > 24 for p, q in zip(before, after))


def choose(browser, control, value):
    browser.evaluate(f"""(() => {{ const c = document.getElementById('{control}'); c.value = '{value}';
      for (const e of ['input', 'change']) c.dispatchEvent(new Event(e, {{bubbles: true}})); }})()""")


def on_screen(browser, point):
    """Where a point [mm] of the model's own frame appears in the window."""
    x, y = browser.evaluate(f"reliefViewer.project({[p + c for p, c in zip(point, CENTRE)]})")
    box = browser.evaluate("(({left, top, width, height}) => [left, top, width, height])(document.getElementById('canvas').getBoundingClientRect())")
    return box[0] + (x + 1) / 2 * box[2], box[1] + (1 - y) / 2 * box[3]


def check_start(browser, faces):
    check(browser.evaluate("reliefViewer.model.indices.length / 3") == faces, f"the viewer has all {faces} faces")
    pixels = browser.evaluate(PIXELS)
    solid = sum(p[3] > 200 for p in pixels)
    check(pixels[40 + 30 * 80][3] > 200 and pixels[0][3] == 0 and 300 < solid < 4000, f"the model covers {solid} of {len(pixels)} pixels, not the corner")
    check(browser.evaluate("document.querySelector('.badge') !== null && document.querySelector('img:not(#pictures img, #views img)') === null"), "names of views are text")
    check(browser.evaluate("[...document.querySelectorAll('#pictures img')].length > 1"), "the model has pictures")
    check(browser.evaluate("document.querySelectorAll('#views .spectrum polyline').length") == 4, "each view has its spectra")
    check(browser.evaluate("document.querySelector('#alignment').textContent.includes('All loops close')"), "the loops are told of")


def check_colourings(browser):
    choose(browser, "look-from", 1)  # From where filled vertices are seen.
    shaded = browser.evaluate(PIXELS)
    for colouring in ("error", "filled", "views", "source"):
        choose(browser, "colouring", colouring)
        changed = differing(shaded, browser.evaluate(PIXELS))
        check(changed > 100, f"colouring by {colouring} changes {changed} pixels")
    choose(browser, "colouring", "error")
    legend = browser.evaluate("document.getElementById('legend').textContent")
    check("mm" in legend and "Expected error" in legend, f"the legend has its unit: {legend}")
    choose(browser, "colouring", "shaded")
    check(differing(shaded, browser.evaluate(PIXELS)) == 0, "shading comes back")


def colour_at(browser, point):
    """The colour of the model's picture where a point [mm] of its own frame appears."""
    return browser.evaluate(f"""(() => {{
      const [x, y] = reliefViewer.project({[p + c for p, c in zip(point, CENTRE)]}), canvas = document.getElementById('canvas');
      reliefViewer.draw();
      const copy = document.createElement('canvas');
      [copy.width, copy.height] = [1, 1];
      const context = copy.getContext('2d');
      context.drawImage(canvas, Math.round((x + 1) / 2 * canvas.width), Math.round((1 - y) / 2 * canvas.height), 1, 1, 0, 0, 1, 1);
      return [...context.getImageData(0, 0, 1, 1).data].slice(0, 3);
    }})()""")


def same_hue(a, b):
    """Whether one colour is the other one in another light."""
    norm = math.sqrt(sum(p * p for p in a) * sum(q * q for q in b))
    return norm > 0 and sum(p * q for p, q in zip(a, b)) / norm > 0.985


def check_source_views(browser):
    choose(browser, "look-from", 0)
    choose(browser, "colouring", "source")
    key = browser.evaluate("""[...document.querySelectorAll('#view-key li')].map(li =>
      [li.textContent, getComputedStyle(li.querySelector('.swatch')).backgroundColor.match(/\\d+/g).map(Number)])""")
    check(len(key) == 2 and key[0][0].startswith("front (") and "escaped" in key[1][0], f"the key names both views: {key}")
    left, right = (colour_at(browser, (x, -SIZE[1] / 2, 0.0)) for x in (-10.0, 10.0))
    check(same_hue(left, key[0][1]) and same_hue(right, key[1][1]), f"each side has the colour of its view: {left} and {right}")
    check(not same_hue(left, right), "the colours of both views differ")
    choose(browser, "look-from", 1)
    filled = colour_at(browser, (12.0, 0.0, SIZE[2] / 2))
    check(max(filled) - min(filled) < 20, f"what is filled is grey: {filled}")
    choose(browser, "colouring", "shaded")
    check(browser.evaluate("document.getElementById('view-key').hidden"), "the key is gone with the colouring")


def check_section(browser):
    whole = browser.evaluate(PIXELS)
    choose(browser, "section-axis", 0)
    half = browser.evaluate(PIXELS)
    check(differing(whole, half) > 200, "the section plane cuts the model")
    place = browser.evaluate("document.getElementById('section-value').textContent")
    check(place.startswith("100 mm"), f"it stands in the middle of the box: {place}")
    choose(browser, "section-place", 900)
    check(differing(half, browser.evaluate(PIXELS)) > 100, "its slider moves it")
    choose(browser, "section-axis", "")
    check(differing(whole, browser.evaluate(PIXELS)) == 0, "without it the model is whole again")


def check_cameras(browser):
    choose(browser, "look-from", 0)
    before = browser.evaluate(PIXELS)
    browser.evaluate("document.getElementById('cameras').click()")
    check(differing(before, browser.evaluate(PIXELS)) > 100, "cameras are shown")
    browser.evaluate("document.getElementById('cameras').click()")


def check_distance(browser):
    choose(browser, "look-from", 0)
    browser.evaluate("document.getElementById('viewer').scrollIntoView({behavior: 'instant'})")
    browser.evaluate("document.getElementById('measure').click()")
    a, b = (-15.0, -SIZE[1] / 2, -6.0), (12.0, -SIZE[1] / 2, 5.0)  # On the front side, not at its corners.
    for point in (a, b):
        browser.click(*on_screen(browser, point))
    distance = float(browser.evaluate("document.getElementById('measured').dataset.distance") or "nan")
    expected = math.dist(a, b)
    # A pixel is the accuracy of a click.
    pixel = 2.0 * math.dist(a, b) / math.dist(on_screen(browser, a), on_screen(browser, b))
    check(abs(distance - expected) < pixel, f"the distance of two picked points is {distance:.4f} mm instead of {expected:.4f}")
    browser.evaluate("document.getElementById('measure').click()")


def check_distance_on_the_cut(browser):
    """What is picked on the cut lies on its plane, not on the wall behind it."""
    choose(browser, "look-from", 1)
    choose(browser, "section-axis", 0)
    choose(browser, "section-place", 500)  # Through the middle of the box: the cut is seen from x > 0.
    browser.evaluate("document.getElementById('measure').click()")
    a, b = (0.0, -8.0, -3.0), (0.0, 7.0, 4.0)
    for point in (a, b):
        browser.click(*on_screen(browser, point))
    distance = float(browser.evaluate("document.getElementById('measured').dataset.distance") or "nan")
    pixel = 2.0 * math.dist(a, b) / math.dist(on_screen(browser, a), on_screen(browser, b))
    check(abs(distance - math.dist(a, b)) < pixel, f"on the cut it is {distance:.4f} mm instead of {math.dist(a, b):.4f}")
    browser.evaluate("document.getElementById('measure').click()")
    choose(browser, "section-axis", "")


def check_mouse(browser):
    before = browser.evaluate(PIXELS)
    x, y = on_screen(browser, (0.0, 0.0, 0.0))
    browser.mouse("mousePressed", x, y, buttons=1)
    for step in range(1, 6):
        browser.mouse("mouseMoved", x + 20 * step, y + 4 * step, buttons=1)
    browser.mouse("mouseReleased", x + 100, y + 20)
    turned = browser.evaluate(PIXELS)
    check(differing(before, turned) > 100, "dragging turns the model")
    browser.call("Input.dispatchMouseEvent", type="mouseWheel", x=x, y=y, deltaX=0, deltaY=-240)
    time.sleep(0.3)
    check(differing(turned, browser.evaluate(PIXELS)) > 50, "the wheel zooms after a click")


def check_keyboard(browser, page):
    """From the top of the page with the keyboard alone: to the canvas, turn, zoom, measure."""
    browser.open(page, 1200, 900)
    reached = []
    for _ in range(60):
        browser.key("Tab", 9)
        reached.append(browser.evaluate("document.activeElement.id"))
        if reached[-1] == "whole":
            break
    wanted = ["canvas", "colouring", "look-from", "section-axis", "cameras", "measure", "whole"]
    check([name for name in reached if name in wanted] == wanted, "Tab reaches all controls")
    browser.key("Enter", 13, "\r")
    browser.evaluate("document.getElementById('canvas').focus()")
    before = browser.evaluate(PIXELS)
    browser.key("ArrowLeft", 37)
    turned = browser.evaluate(PIXELS)
    check(differing(before, turned) > 50, "an arrow key turns the model")
    browser.key("+", 187, "+")
    nearer = browser.evaluate(PIXELS)
    check(sum(p[3] > 200 for p in nearer) > sum(p[3] > 200 for p in turned), "plus comes nearer")
    browser.key("0", 48, "0")
    check(differing(before, browser.evaluate(PIXELS)) < 20, "0 shows the whole model again")
    browser.key("m", 77, "m")
    browser.key("Enter", 13, "\r")
    for _ in range(2):
        browser.key("ArrowRight", 39)
    browser.key("Enter", 13, "\r")
    check(float(browser.evaluate("document.getElementById('measured').dataset.distance") or 0) > 1.0, "two points are picked at the cross")
    browser.evaluate("document.getElementById('colouring').focus()")
    browser.evaluate("document.getElementById('colouring').value")
    for letter in "source":
        browser.key(letter, ord(letter.upper()), letter)
    check(browser.evaluate("document.getElementById('colouring').value") == "source", "typing its name chooses a colouring")
    browser.key("Tab", 9)


def check_phone(browser, page):
    browser.open(page, 375, 740, phone=True)
    width = browser.evaluate("[document.documentElement.scrollWidth, innerWidth]")
    check(width[0] <= 375 and width[1] == 375, f"a phone needs no sideways scrolling: {width[0]} of {width[1]} pixels")
    browser.evaluate("document.getElementById('viewer').scrollIntoView({behavior: 'instant'})")
    before = browser.evaluate(PIXELS)
    x, y = on_screen(browser, (0.0, 0.0, 0.0))
    browser.call("Input.dispatchTouchEvent", type="touchStart", touchPoints=[{"x": x, "y": y}])
    for step in range(1, 6):
        browser.call("Input.dispatchTouchEvent", type="touchMove", touchPoints=[{"x": x + 15 * step, "y": y}])
    browser.call("Input.dispatchTouchEvent", type="touchEnd", touchPoints=[])
    check(differing(before, browser.evaluate(PIXELS)) > 50, "a finger turns the model")


def check_without_webgl(program, folder, page):
    browser = Browser(program, folder / "profile-2", ["--disable-3d-apis"])
    try:
        browser.open(page, 1000, 800)
        check(browser.evaluate("document.querySelector('#viewer > .no-viewer').checkVisibility() && !document.getElementById('canvas').checkVisibility()"),
              "without WebGL a message stands in the viewer's place")
        check(browser.evaluate("document.querySelectorAll('section').length > 3"), "and the page can be read")
    finally:
        browser.close()


def main():
    program = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if not program:
        print("skipped: there is no Chromium (scripts/setup --browser installs it)")
        return SKIPPED
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as name:
        folder = pathlib.Path(name)
        faces = write_run(folder)
        subprocess.run([sys.argv[1], "report", "-q", str(folder)], check=True)
        page = folder / "report.html"
        browser = Browser(program, folder / "profile")
        try:
            start = time.monotonic()
            browser.open(page, 1200, 900)
            print(f"        the page is there after {time.monotonic() - start:.2f} s")
            check_start(browser, faces)
            check_colourings(browser)
            check_source_views(browser)
            check_section(browser)
            check_cameras(browser)
            check_distance(browser)
            check_distance_on_the_cut(browser)
            check_mouse(browser)
            check_keyboard(browser, page)
            check_phone(browser, page)
            check(not browser.faults, f"no errors in the console: {browser.faults}")
        finally:
            browser.close()
        check_without_webgl(program, folder, page)
    return 1 if check.failed else 0


if __name__ == "__main__":
    sys.exit(main())
