/**
 * Transports: what carries messages between page and server. A notebook gives its own.
 *
 * @typedef {object} Handlers
 * @property {() => void} onopen
 * @property {(buffer: ArrayBuffer) => void} onmessage
 * @property {() => void} onclose
 *
 * @typedef {{send(buffer: ArrayBuffer): void, close(): void}} Connection
 *
 * @typedef {(since: number, handlers: Handlers) => Connection} Connect
 */

/**
 * A WebSocket to the server that served the page.
 * @param {Location} location
 * @param {string} window  identifies this window
 * @returns {Connect}
 */
export function webSocket(location, window) {
  const token = new URLSearchParams(location.search).get("token") ?? "";
  const scheme = location.protocol === "https:" ? "wss" : "ws";
  return (since, handlers) => {
    const query = new URLSearchParams({ token, window, since: String(since) });
    const socket = new WebSocket(`${scheme}://${location.host}/socket?${query}`);
    socket.binaryType = "arraybuffer";
    socket.onopen = handlers.onopen;
    socket.onmessage = (event) => handlers.onmessage(event.data);
    socket.onclose = handlers.onclose;
    return { send: (buffer) => socket.send(buffer), close: () => socket.close() };
  };
}
