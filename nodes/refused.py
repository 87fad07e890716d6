"""Messages that must not act on the simulation. The text of each says why and what is allowed."""


class RefusedInputError(ValueError):
    """A message was refused. `counter` is the diagnostics value that counts it."""

    counter = "refused"


class MalformedMessageError(RefusedInputError):
    """The bytes are not a message of the topic's type."""

    counter = "refused_malformed"


class UnknownFrameError(RefusedInputError):
    """The frame_id is not one in which this message can be given."""

    counter = "refused_frame"


class RefusedValueError(RefusedInputError):
    """A number is NaN, infinite or not allowed."""

    counter = "refused_value"


class WrongStampError(RefusedInputError):
    """In lockstep: not the message for the next step."""

    counter = "refused_stamp"


class RefusedBodyError(RefusedInputError):
    """A body can't be added, removed or changed as asked."""

    counter = "refused_body"
