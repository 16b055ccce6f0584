"""The chunk table of a LAZ file: a list of (points, bytes), coded arithmetically. decode() and encode() are all that cutting a file needs.

Source: rapidlasso, LAZ Specification 1.4; A. Said, Introduction to Arithmetic Coding (HP Labs 2004)."""


class SymbolModel:
    """Symbols whose probabilities are learnt; shares are cumulative, of 2^15."""

    def __init__(self, size):
        self.counts, self.total, self.cycle = [1] * size, 0, size
        self.update()
        self.cycle = self.left = (size + 6) >> 1

    def update(self):
        self.total += self.cycle
        if self.total > 1 << 15:
            self.counts = [(count + 1) >> 1 for count in self.counts]
            self.total = sum(self.counts)
        scale, below, self.shares = 0x80000000 // self.total, 0, []
        for count in self.counts:
            self.shares.append(scale * below >> 16)
            below += count
        self.cycle = self.left = min(5 * self.cycle >> 2, (len(self.counts) + 6) << 3)

    def learn(self, symbol):
        self.counts[symbol] += 1
        self.left -= 1
        if self.left == 0:
            self.update()


class BitModel:
    """A bit whose probability is learnt; the share of 0 is of 2^13."""

    def __init__(self):
        self.zeros, self.total, self.share, self.cycle, self.left = 1, 2, 1 << 12, 4, 4

    def learn(self, bit):
        self.zeros += not bit
        self.left -= 1
        if self.left > 0:
            return
        self.total += self.cycle
        if self.total > 1 << 13:
            self.total, self.zeros = (self.total + 1) >> 1, (self.zeros + 1) >> 1
            self.total += self.zeros == self.total
        self.share = self.zeros * (0x80000000 // self.total) >> 18
        self.cycle = self.left = min(5 * self.cycle >> 2, 64)


class Decoder:
    def __init__(self, data):
        self.data, self.at, self.value, self.length = data, 4, int.from_bytes(data[:4], "big"), 0xFFFFFFFF

    def taken(self, low, high):
        self.value, self.length = self.value - low, high - low
        while self.length < 1 << 24:
            byte = self.data[self.at] if self.at < len(self.data) else 0
            self.value, self.length, self.at = self.value << 8 | byte, self.length << 8, self.at + 1

    def symbol(self, model, _):
        unit = self.length >> 15
        symbol = max(s for s, share in enumerate(model.shares) if share * unit <= self.value)
        last = symbol + 1 == len(model.shares)
        self.taken(model.shares[symbol] * unit, self.length if last else model.shares[symbol + 1] * unit)
        model.learn(symbol)
        return symbol

    def bit(self, model, _):
        zero = model.share * (self.length >> 13)
        bit = self.value >= zero
        self.taken(zero if bit else 0, self.length if bit else zero)
        model.learn(bit)
        return int(bit)

    def bits(self, count, _):
        if count > 19:
            low = self.bits(16, _)
            return self.bits(count - 16, _) << 16 | low
        self.length >>= count
        bits = self.value // self.length
        self.taken(bits * self.length, (bits + 1) * self.length)
        return bits


class Encoder:
    """The same calls as Decoder's, which return the value that they are given."""

    def __init__(self):
        self.base, self.length, self.shifted = 0, 0xFFFFFFFF, 0  # base: of all that was written, a whole number

    def taken(self, low, high):
        self.base, self.length = self.base + low, high - low
        while self.length < 1 << 24:
            self.base, self.length, self.shifted = self.base << 8, self.length << 8, self.shifted + 1

    def symbol(self, model, symbol):
        unit = self.length >> 15
        last = symbol + 1 == len(model.shares)
        self.taken(model.shares[symbol] * unit, self.length if last else model.shares[symbol + 1] * unit)
        model.learn(symbol)
        return symbol

    def bit(self, model, bit):
        zero = model.share * (self.length >> 13)
        self.taken(zero if bit else 0, self.length if bit else zero)
        model.learn(bit)
        return bit

    def bits(self, count, value):
        if count > 19:
            self.bits(16, value & 0xFFFF)
            self.bits(count - 16, value >> 16)
            return value
        self.length >>= count
        self.taken(value * self.length, (value + 1) * self.length)
        return value

    def finish(self):
        half = self.length // 2
        self.taken(half, half + (1 << 23))
        return self.base.to_bytes(self.shifted + 4, "big")


class Integers:
    """32-bit numbers as corrections of the one before; each context has a model of its own for how long corrections are."""

    def __init__(self, coder, contexts):
        self.coder, self.zero_or_one = coder, BitModel()
        self.lengths, self.upper = [SymbolModel(33) for _ in range(contexts)], {}

    def next(self, before, value, context):
        """`value` is what an encoder writes, and 0 for a decoder; returns the number."""
        wanted = (value - before + 0x80000000) % (1 << 32) - 0x80000000
        length = self.coder.symbol(self.lengths[context], (-wanted if wanted <= 0 else wanted - 1).bit_length())
        if length == 0:
            return before + self.coder.bit(self.zero_or_one, wanted)
        if length == 32:
            return before - 0x80000000
        code = wanted + (1 << length) - 1 if wanted < 0 else wanted - 1
        model = self.upper.setdefault(length, SymbolModel(1 << min(length, 8)))
        low = max(0, length - 8)
        got = self.coder.symbol(model, code >> low)
        if low > 0:
            got = got << low | self.coder.bits(low, code & ((1 << low) - 1))
        return before + (got + 1 if got >= 1 << (length - 1) else got - (1 << length) + 1)


def code(coder, chunks, variable):
    """`chunks`: pairs (points, bytes); `variable`: points stand in the table, too. Returns the pairs that were coded."""
    integers, points, size, coded = Integers(coder, 2), 0, 0, []
    for chunk_points, chunk_size in chunks:
        points = integers.next(points, chunk_points, 0) if variable else chunk_points
        size = integers.next(size, chunk_size, 1)
        coded.append((points, size))
    return coded


def decode(data, chunk_points, variable):
    """The table whose codes begin `data`. `chunk_points`: of each chunk, as far as the file tells (0 where the table does)."""
    return code(Decoder(data), [(points, 0) for points in chunk_points], variable)


def encode(chunks, variable):
    encoder = Encoder()
    code(encoder, chunks, variable)
    return encoder.finish()
