"""A sentence for the report on the harm of an effect that is present and not in the model, but leaves no residual."""

from __future__ import annotations

from scalar.effects.wording import length

LEAST_HARM = 1e-6  # m, chosen: smaller prediction errors are not stated as a number


def consequence_in_words(size: str, error: float, remedy: str) -> str:
    """Return the sentence on an effect of natural size that these data cannot show.

    Args:
        size: Size of the effect, with its unit.
        error: Error of predicted positions [m] if the effect is present and not in the model.
        remedy: What would make the effect observable, a clause; may be empty.
    """
    if error < LEAST_HARM:
        return (
            f"an error of {size} would leave no residual and move predicted positions by less than "
            f"{length(LEAST_HARM)}"
        )
    text = (
        f"an error of {size} would leave no residual and put predicted positions off by about {length(error)}"
    )
    return f"{text}; {remedy}" if remedy else text
