"""The parts of the formatter; `arael.syntax.fmt` is its public interface."""
