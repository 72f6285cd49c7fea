"""Names of the Rust framework, and their equivalents."""

from __future__ import annotations

import re

_TYPES = {
    "vect2": "vec2", "vect3": "vec3", "vect4": "vec<4>", "matrix2": "mat2", "matrix3": "mat3",
    "quatern": "quat", "f32": "real", "f64": "real", "float": "real", "double": "real",
    "usize": "int", "u8": "int", "i8": "int", "u16": "int", "i16": "int", "i32": "int",
    "i64": "int", "u32": "int", "u64": "int", "String": "string", "str": "string",
}  # fmt: skip

# Parameter types: what follows `param name:`.
PARAMETERS = {
    "SimpleEulerAngleParam": "euler", "EulerAngleParam": "rotation", "AngleParam": "angle",
    "QuaternionParam": "quaternion", "DirectionParam": "direction", "TransformParam": "transform",
    "SimilarityParam": "similarity",
}  # fmt: skip

_METHODS = {
    "get_euler_angles": "write `.euler_angles()`",
    "get_rotation_matrix": "write `.rotation_matrix()`",
    "is_some": "presence is tested by the name: `when info.gps`, `if info.gps then ...`",
    "is_none": "presence is tested by the name: `when not info.gps`",
    "unwrap": "omit it: after `when x`, `x` is present",
    "clone": "omit it",
    "work": "omit it: the name of a parameter is its trial value",
    "value": "write `.value` without parentheses",
    "powi": "write `x ^ n`",
    "powf": "write `x ^ n`",
    "length": "write `norm(v)`",
    "magnitude": "write `norm(v)`",
    "normalize": "write `unit(v)`",
    "normalized": "write `unit(v)`",
    "norm_squared": "write `norm2(v)`",
    "len": "a constraint is evaluated for each element, and cannot count them",
    "iter": "a constraint is evaluated for each element: put it into the element's struct",
    "ln": "write `log(x)`",
}


def plain_type(name: str) -> str:
    """The arael name of a Rust type without parameters; or `name` itself."""
    inner = re.fullmatch(r"(\w+)<.*>?", name)
    name = inner[1] if inner else name
    return _TYPES.get(name) or _TYPES.get(re.sub(r"[fd]$", "", name)) or name


def type_advice(name: str) -> list[str]:
    """Help for the Rust type `name`; empty for other names."""
    if name in PARAMETERS:
        return [f"write `param x: {PARAMETERS[name]}`"]
    plain = plain_type(name)
    return [f"write `{plain}`"] if plain != name else []


def method_advice(name: str) -> list[str]:
    """Help for a method of the Rust framework; empty for other names."""
    return [_METHODS[name]] if name in _METHODS else []
