"""The language server: models as one types, in every editor that speaks the protocol."""
