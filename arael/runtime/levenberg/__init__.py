"""The parts of the loop of a solve that judge one component: settings, records, damping, ends."""
