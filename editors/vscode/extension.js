// @ts-check
// Starts the language server and connects the editor with it.

"use strict";

const vscode = require("vscode");
const { LanguageClient, TransportKind } = require("vscode-languageclient/node");

/** @type {import("vscode-languageclient/node").LanguageClient | undefined} */
let client;

/** Starts a server with the command of the settings. */
async function start() {
  const words = vscode.workspace.getConfiguration("arael").get("command", ["arael", "lsp"]);
  const [command, ...args] = words;
  client = new LanguageClient(
    "arael",
    "arael",
    { command, args, transport: TransportKind.stdio },
    { documentSelector: [{ scheme: "file", language: "arael" }] },
  );
  try {
    await client.start();
  } catch (error) {
    const choice = await vscode.window.showErrorMessage(
      `arael: \`${words.join(" ")}\` does not start (${error}). Install it with ` +
        "`pip install \"arael[lsp]\"`, or set `arael.command`.",
      "Open settings",
    );
    if (choice) await vscode.commands.executeCommand("workbench.action.openSettings", "arael.command");
  }
}

/** Ends the server. */
async function stop() {
  const ended = client;
  client = undefined;
  if (ended?.isRunning()) await ended.stop();
}

/** @param {vscode.ExtensionContext} context */
async function activate(context) {
  const restart = async () => {
    await stop();
    await start();
  };
  context.subscriptions.push(
    vscode.commands.registerCommand("arael.restart", restart),
    vscode.workspace.onDidChangeConfiguration((event) => {
      if (event.affectsConfiguration("arael.command")) void restart();
    }),
  );
  await start();
}

module.exports = { activate, deactivate: stop };
