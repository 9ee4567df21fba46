// A page that is opened from disk may not start a worker, and the search runs in one. This stands in for it there: the script of
// the worker is loaded into a hidden frame, and messages go to and fro between frame and page.
if (location.protocol === "file:") {
  window.Worker = class extends EventTarget {
    constructor(url) {
      super();
      const frame = document.createElement("iframe");
      frame.hidden = true;
      document.body.append(frame);
      const inside = frame.contentWindow;
      const worker = new URL(url, location.href);
      const load = (address) => new Promise((done, failed) => {
        const script = inside.document.createElement("script");
        script.src = new URL(address, worker);
        script.onload = done;
        script.onerror = () => failed(new Error(`cannot load ${script.src}`));
        inside.document.body.append(script);
      });
      inside.importScripts = (...addresses) => addresses.reduce((before, next) => before.then(() => load(next)), Promise.resolve());
      inside.postMessage = (data) => this.dispatchEvent(Object.assign(new MessageEvent("message", {data})));
      this.inside = inside;
      this.loaded = load(worker);
    }
    postMessage(data) {
      this.loaded.then(() => this.inside.dispatchEvent(new MessageEvent("message", {data})));
    }
  };
}
