"""Opens reports in headless Chromium over its debugging pipe and expects of each: no console error, no network request,
no script, its figures and tables, nothing wider than the page, in light and dark, on a telephone and on paper.

    tests/read_report.py FOLDER REPORT...    screenshots and PDFs go to FOLDER"""

import base64
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import threading

FLAGS = ["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
         "--disable-component-update", "--disable-sync", "--disable-dev-shm-usage", "--remote-debugging-pipe"]


class Browser:
    """Chromium and its messages: JSON texts that end in NUL, to its descriptor 3 and from its descriptor 4."""

    def __init__(self, profile):
        to_read, self.to = os.pipe()
        self.back, back_write = os.pipe()
        command = ["bash", "-c", f'exec chromium "$@" 3<&{to_read} 4>&{back_write}', "chromium", *FLAGS, f"--user-data-dir={profile}",
                   "about:blank"]
        self.process = subprocess.Popen(command, pass_fds=(to_read, back_write), stderr=subprocess.DEVNULL)
        os.close(to_read)
        os.close(back_write)
        self.buffer, self.number, self.events = b"", 0, []
        # A browser that hangs ends the test, not the patience.
        self.watchdog = threading.Timer(180, self.process.kill)
        self.watchdog.start()

    def receive(self):
        while b"\0" not in self.buffer:
            part = os.read(self.back, 1 << 20)
            if not part:
                sys.exit("read_report: chromium has gone")
            self.buffer += part
        text, self.buffer = self.buffer.split(b"\0", 1)
        return json.loads(text)

    def call(self, method, session=None, **params):
        self.number += 1
        message = {"id": self.number, "method": method, "params": params}
        if session:
            message["sessionId"] = session
        data = json.dumps(message).encode() + b"\0"
        while data:
            data = data[os.write(self.to, data):]
        while True:
            answer = self.receive()
            if answer.get("id") == self.number:
                if "error" in answer:
                    sys.exit(f"read_report: {method}: {answer['error']['message']}")
                return answer["result"]
            self.events.append(answer)

    def wait(self, method):
        while not any(e.get("method") == method for e in self.events):
            self.events.append(self.receive())

    def close(self):
        self.watchdog.cancel()
        self.call("Browser.close")
        self.process.wait()


class Page:
    """A file in a tab of its own, opened, and what happened meanwhile."""

    def __init__(self, browser, path):
        self.browser = browser
        browser.events.clear()
        target = browser.call("Target.createTarget", url="about:blank")["targetId"]
        self.session = browser.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Network", "Log", "Runtime"):
            self.call(f"{domain}.enable")
        self.call("Page.navigate", url=pathlib.Path(path).resolve().as_uri())
        browser.wait("Page.loadEventFired")
        # Anything that the page asks for late.
        self.evaluate("new Promise(done => setTimeout(done, 300))")

    def call(self, method, **params):
        return self.browser.call(method, self.session, **params)

    def evaluate(self, text):
        answer = self.call("Runtime.evaluate", expression=text, returnByValue=True, awaitPromise=True)
        return answer["result"].get("value")

    def errors(self):
        found = []
        for e in self.browser.events:
            p = e.get("params", {})
            if e.get("method") == "Runtime.exceptionThrown":
                found.append(p["exceptionDetails"]["text"])
            elif e.get("method") == "Runtime.consoleAPICalled" and p["type"] in ("error", "warning", "assert"):
                found.append(str(p["args"]))
            elif e.get("method") == "Log.entryAdded" and p["entry"]["level"] in ("error", "warning"):
                found.append(p["entry"]["text"])
        return found

    def requests(self):
        urls = [e["params"]["request"]["url"] for e in self.browser.events if e.get("method") == "Network.requestWillBeSent"]
        # The page itself is a file, and its pictures are in it.
        return [u for u in urls[1:] if not u.startswith("data:")]

    def shows(self, width, height, scheme, out):
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=False)
        self.call("Emulation.setEmulatedMedia", media="screen", features=[{"name": "prefers-color-scheme", "value": scheme}])
        picture = self.call("Page.captureScreenshot", captureBeyondViewport=True)["data"]
        pathlib.Path(out).write_bytes(base64.b64decode(picture))
        return self.evaluate("document.documentElement.scrollWidth - window.innerWidth")


passed = 0


def expect(condition, message):
    global passed
    if not condition:
        sys.exit(f"read_report: {message}")
    passed += 1


folder, reports = pathlib.Path(sys.argv[1]), sys.argv[2:]
# The profile is deleted whatever chromium still writes into it.
with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
    browser = Browser(profile)

    # What this test looks for, it finds where it is.
    bad = folder / "bad.html"
    bad.write_text("<script>console.error('seen'); undefinedFunction()</script><img src='http://127.0.0.1:9/x.png'>")
    page = Page(browser, bad)
    expect(len(page.errors()) >= 2, f"errors of a bad page go unnoticed: {page.errors()}")
    expect(any("127.0.0.1" in u for u in page.requests()), "a request of a bad page goes unnoticed")

    for path in reports:
        page = Page(browser, path)
        expect(not page.errors(), f"{path}: {page.errors()}")
        expect(not page.requests(), f"{path}: asks for {page.requests()}")
        expect(page.evaluate("document.scripts.length") == 0, f"{path}: has a script")
        outside = "[...document.querySelectorAll('[src],link[href],image')].map(e => e.getAttribute('src') || e.getAttribute('href')" \
                  " || e.getAttribute('xlink:href')).filter(u => u && !u.startsWith('data:'))"
        expect(page.evaluate(outside) == [], f"{path}: refers to {page.evaluate(outside)}")
        titles = page.evaluate("[...document.querySelectorAll('figure h3')].map(e => e.textContent)")
        expect({"Vorticity", "Streamlines", "Forces", "Iterations and divergence"} <= set(titles), f"{path}: figures {titles}")
        expect(page.evaluate("[...document.querySelectorAll('figure svg')].every(e => e.getBoundingClientRect().height > 100)"),
               f"{path}: a figure is not drawn")
        sections = page.evaluate("[...document.querySelectorAll('section')].map(e => e.id)")
        expect(set(sections) >= {"measures", "flow", "scene", "numbers", "needs", "numerics", "cost", "reproduce"}, f"{path}: {sections}")
        links = page.evaluate("[...document.querySelectorAll('nav a')].every(a => document.querySelector(a.getAttribute('href')))")
        expect(links, f"{path}: a link leads nowhere")
        stem = folder / (pathlib.Path(path).parent.name + "-" + pathlib.Path(path).stem)
        for width, scheme in ((1280, "light"), (1280, "dark"), (390, "light")):
            over = page.shows(width, 900, scheme, f"{stem}-{scheme}-{width}.png")
            expect(over <= 0, f"{path}: {over} pixels wider than a window of {width}")
        background = "getComputedStyle(document.body).backgroundColor"
        page.call("Emulation.setEmulatedMedia", media="print", features=[{"name": "prefers-color-scheme", "value": "dark"}])
        expect(page.evaluate(background) == "rgb(255, 255, 255)", f"{path}: is printed on {page.evaluate(background)}")
        pdf = base64.b64decode(page.call("Page.printToPDF", preferCSSPageSize=True)["data"])
        expect(pdf.startswith(b"%PDF"), f"{path}: cannot be printed")
        pathlib.Path(f"{stem}.pdf").write_bytes(pdf)
    browser.close()
print(f"{passed} passed, 0 failed")
