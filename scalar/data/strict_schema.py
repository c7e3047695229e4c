"""JSON schemas in which ``integer`` excludes 1.0."""

from typing import Any

from jsonschema import Draft202012Validator
from jsonschema.validators import extend


def _is_integer(_: Any, value: Any) -> bool:
    return isinstance(value, int) and not isinstance(value, bool)


_Strict: Any = extend(
    Draft202012Validator, type_checker=Draft202012Validator.TYPE_CHECKER.redefine("integer", _is_integer)
)


def strict_validator(schema: Any) -> Draft202012Validator:
    """Return a validator of a schema in which ``integer`` means a number without a decimal point.

    The JSON schema standard counts 1.0 as an integer. Indexing a list with it or counting with it fails, so it is
    refused when it is read.
    """
    return _Strict(schema)
