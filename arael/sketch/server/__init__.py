"""The editor's server: one document, several windows, a journal, over a WebSocket."""
