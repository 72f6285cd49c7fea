"""Exported code beside Ceres' automatic differentiation, beside Python, and on a Cortex-M7."""
