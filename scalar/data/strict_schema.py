"""JSON schemas in which an integer is an integer: 1.0 is refused where one is asked for."""

from typing import Any

from jsonschema import Draft202012Validator
from jsonschema.validators import extend


def _is_integer(_: Any, value: Any) -> bool:
    return isinstance(value, int) and not isinstance(value, bool)


_Strict: Any = extend(
    Draft202012Validator, type_checker=Draft202012Validator.TYPE_CHECKER.redefine("integer", _is_integer)
)


def strict_validator(schema: Any) -> Draft202012Validator:
    """Return a validator of a schema in which ``integer`` means what is written without a point.

    The JSON schema standard counts 1.0 as an integer. Indexing a list or counting with it fails, so that it is
    refused where it is read.
    """
    return _Strict(schema)
