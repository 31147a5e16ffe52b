"""Klipper's protocol between host and micro-controller: blocks, integers and messages by the board's dictionary."""

import json
import zlib

SYNC = 0x7E
LEAST, MOST = 5, 64
# Ids that are the same on every board, with the formats by which the dictionary is fetched.
BOOTSTRAP = {"commands": {"identify offset=%u count=%c": 1}, "responses": {"identify_response offset=%u data=%.*s": 0}}
BUFFERS = ("%s", "%*s", "%.*s")


def crc_table():
    table = []
    for value in range(256):
        for _ in range(8):
            value = value >> 1 ^ (0x8408 if value & 1 else 0)
        table.append(value)
    return table


CRC_TABLE = crc_table()


def crc16(data):
    """Reflected polynomial 0x8408, from 0xffff."""
    crc = 0xFFFF
    for byte in data:
        crc = crc >> 8 ^ CRC_TABLE[(crc ^ byte) & 0xFF]
    return crc


def block(sequence, content=b""):
    head = bytes((len(content) + LEAST, 0x10 | sequence & 0xF)) + content
    return head + crc16(head).to_bytes(2, "big") + bytes((SYNC,))


def encode_integer(value):
    value = (value + (1 << 31)) % (1 << 32) - (1 << 31) if value >= 1 << 32 or value < -(1 << 31) else value
    out = [value & 0x7F]
    for bits in (5, 12, 19, 26):
        if -(1 << bits) <= value < 3 << bits:
            break
        out.append(value >> bits + 2 & 0x7F | 0x80)
    return bytes(reversed(out))


def decode_integer(data, at):
    """The value, modulo 2^32 as the board has it, and where the next one begins."""
    byte = data[at]
    value = byte & 0x7F
    if byte & 0x60 == 0x60:
        value -= 0x80
    while byte & 0x80:
        at += 1
        byte = data[at]
        value = value << 7 | byte & 0x7F
    return value & 0xFFFFFFFF, at + 1


class Splitter:
    """Cuts a stream into blocks. What is none counts as noise, once for each stretch of it."""

    def __init__(self):
        self.held = bytearray()
        self.is_lost = False
        self.noise = 0

    def lose(self, blocks):
        if not self.is_lost:
            self.noise += 1
        at = self.held.find(SYNC)
        self.is_lost = at < 0
        del self.held[: at + 1 if at >= 0 else len(self.held)]

    def feed(self, data):
        """Returns the blocks that are complete now: number and content of each."""
        blocks, held = [], self.held
        held += data
        while held:
            if self.is_lost:
                self.lose(blocks)
            elif held[0] == SYNC:
                del held[0]
            elif not LEAST <= held[0] <= MOST or len(held) > 1 and held[1] & 0xF0 != 0x10:
                self.lose(blocks)
            elif len(held) < held[0]:
                break
            else:
                whole = bytes(held[: held[0]])
                if whole[-1] != SYNC or crc16(whole[:-3]) != int.from_bytes(whole[-3:-1], "big"):
                    self.lose(blocks)
                    continue
                del held[: len(whole)]
                blocks.append((whole[1] & 0xF, whole[2:-3]))
        return blocks


class Message:
    """A format string of the dictionary."""

    def __init__(self, text, number):
        self.name, *fields = text.split()
        self.number = number
        self.fields = [tuple(field.split("=", 1)) for field in fields]

    def read(self, data, at):
        values = {}
        for name, kind in self.fields:
            value, at = decode_integer(data, at)
            if kind in BUFFERS:
                value, at = bytes(data[at : at + value]), at + value
            elif kind in ("%i", "%hi") and value >= 1 << 31:
                value -= 1 << 32
            values[name] = value
        return values, at

    def write(self, values):
        out = bytearray(encode_integer(self.number))
        for name, kind in self.fields:
            value = values[name]
            if kind in BUFFERS:
                out += encode_integer(len(value)) + value
            else:
                out += encode_integer(value)
        return bytes(out)


class Dictionary:
    """What a board says of itself; to begin with, what every board has in common."""

    def __init__(self, compressed=None):
        self.facts = json.loads(zlib.decompress(compressed)) if compressed else {}
        self.commands, self.responses = (self.messages(kind) for kind in ("commands", "responses"))
        self.by_name = {message.name: message for message in self.commands.values()}
        self.config = self.facts.get("config", {})

    def messages(self, kind):
        texts = {**self.facts.get(kind, {}), **(self.facts.get("output", {}) if kind == "responses" else {}), **BOOTSTRAP[kind]}
        return {number & 0xFFFFFFFF: Message(text, number) for text, number in texts.items()}

    def numbers(self, name):
        """An enumeration with its ranges written out: number by name."""
        found = {}
        for text, value in self.facts.get("enumerations", {}).get(name, {}).items():
            if isinstance(value, int):
                found[text] = value
                continue
            stem = text.rstrip("0123456789")
            first = int(text[len(stem) :])
            found.update({f"{stem}{first + index}": value[0] + index for index in range(value[1])})
        return found

    def read(self, content, messages):
        """The messages of a block, each as its name and its values; an unknown number ends it."""
        out, at = [], 0
        while at < len(content):
            number, at = decode_integer(content, at)
            message = messages.get(number)
            if message is None:
                out.append(("?", {"number": number}))
                break
            values, at = message.read(content, at)
            out.append((message.name, values))
        return out
