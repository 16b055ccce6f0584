#include "src/result/store/integer_block.h"

#include <algorithm>
#include <bit>
#include <cstring>

#include "src/base/check.h"
#include "src/result/store/byte_planes.h"

namespace tessera::store {

namespace {

// What is subtracted: the least number of the block, or from each number the one before it.
enum class Relative : std::uint8_t { to_least, to_previous };

struct BlockHead {
  Relative relative;
  std::uint8_t planes;
  std::uint64_t base;  // the least number, or the first
};
constexpr std::size_t head_bytes = 10;

// n log2(n) in units of 1/1024, rounded down. Computed with integers, so that every machine decides alike.
constexpr std::size_t sampled_at_most = 2048;
constexpr std::array<std::uint32_t, sampled_at_most + 1> make_entropy_table() {
  std::array<std::uint32_t, sampled_at_most + 1> table{};
  for (std::uint64_t n = 2; n <= sampled_at_most; ++n) {
    const auto whole = static_cast<std::uint64_t>(std::bit_width(n) - 1);
    std::uint64_t logarithm = whole, rest = n << (30 - whole);  // 1 <= rest / 2^30 < 2
    for (int bit = 0; bit < 10; ++bit) {
      rest = rest * rest >> 30u;
      logarithm = logarithm << 1u | rest >> 31u;
      if (rest >> 31u != 0) rest >>= 1u;
    }
    table[n] = static_cast<std::uint32_t>(n * logarithm);
  }
  return table;
}
constexpr auto entropy_table = make_entropy_table();

// Counts the bytes in the planes of a sample.
class PlaneCosts {
 public:
  void add(std::uint64_t number) {
    ++added_;
    for (std::size_t plane = 0; plane < planes_max; ++plane, number >>= 8u) ++counts_[plane][number & 0xffu];
  }
  // The cost of packing the planes byte by byte, up to a constant; less is better.
  std::int64_t cost() const {
    std::int64_t sum = 0;
    for (std::size_t plane = 0; plane < planes_max; ++plane) sum -= order(plane);
    return sum;
  }
  // True for bytes with an entropy of nearly 8 bits. In a sample as small as this, random bytes show 7.91.
  bool is_noise(std::size_t plane) const {
    constexpr double bits = 7.8, all = 11;
    static_assert(std::size_t{1} << static_cast<unsigned>(all) == sampled_at_most);
    return added_ == sampled_at_most && order(plane) < static_cast<std::int64_t>((all - bits) * 1024 * sampled_at_most);
  }

 private:
  std::int64_t order(std::size_t plane) const {
    std::int64_t sum = 0;
    for (const std::uint16_t count : counts_[plane]) sum += entropy_table[count];
    return sum;
  }

  std::size_t added_ = 0;
  std::array<std::array<std::uint16_t, 256>, planes_max> counts_{};
};

struct Choice {
  Relative relative = Relative::to_least;
  std::array<bool, planes_max> noise{};
};

// Chooses by a sample of runs, spread evenly over the block.
Choice better(std::span<const std::uint64_t> numbers, std::uint64_t least) {
  constexpr std::size_t run = 32, runs = sampled_at_most / run;
  const std::size_t step = std::max(run, numbers.size() / runs);
  PlaneCosts to_least, to_previous;
  for (std::size_t first = 0, taken = 0; first < numbers.size() && taken < runs; first += step, ++taken) {
    const std::size_t end = std::min(first + run, numbers.size());
    for (std::size_t i = first; i < end; ++i) {
      to_least.add(numbers[i] - least);
      to_previous.add(folded(i == 0 ? 0 : numbers[i] - numbers[i - 1]));
    }
  }
  Choice choice;
  if (to_previous.cost() < to_least.cost()) choice.relative = Relative::to_previous;
  for (std::size_t p = 0; p < planes_max; ++p)
    choice.noise[p] = (choice.relative == Relative::to_least ? to_least : to_previous).is_noise(p);
  return choice;
}

bool all_equal(std::span<const std::uint64_t> numbers) {
  std::uint64_t differing = 0;
  const std::uint64_t first = numbers[0];
  for (const std::uint64_t number : numbers) differing |= number ^ first;
  return differing == 0;
}

// Subtracts as `head` says. Returns the bitwise or of all results.
std::uint64_t move(std::span<const std::uint64_t> numbers, const BlockHead& head, std::uint64_t* to) {
  std::uint64_t bits = 0;
  if (head.relative == Relative::to_least) {
    for (const std::uint64_t number : numbers) bits |= * to++ = number - head.base;
  } else {
    std::uint64_t previous = head.base;
    for (const std::uint64_t number : numbers) {
      bits |= * to++ = folded(number - previous);
      previous = number;
    }
  }
  return bits;
}

const char* move_back(const BlockHead& head, std::span<std::uint64_t> numbers) {
  if (head.relative == Relative::to_least) {
    bool least_is_there = false;
    for (std::uint64_t& number : numbers) {
      least_is_there |= number == 0;
      number += head.base;
    }
    return least_is_there ? nullptr : "does not contain the least number that it announces";
  }
  if (numbers[0] != 0) return "does not begin with the first number that it announces";
  std::uint64_t previous = head.base;
  for (std::uint64_t& number : numbers) previous = number = previous + unfolded(number);
  return nullptr;
}

}  // namespace

void IntegerBlocks::append(std::span<const std::uint64_t> numbers, BigVector<std::byte>& to) {
  const std::size_t rows = numbers.size();
  check(rows > 0 && rows <= block_rows, "a block has 1 to block_rows rows");
  BlockHead head{Relative::to_least, 0, numbers[0]};
  Choice choice;
  if (!all_equal(numbers)) {
    head.base = *std::min_element(numbers.begin(), numbers.end());
    choice = better(numbers, head.base);
    head.relative = choice.relative;
    if (head.relative == Relative::to_previous) head.base = numbers[0];
    moved_.resize(std::max(moved_.size(), rows));
    const std::uint64_t bits = move(numbers, head, moved_.data());
    head.planes = static_cast<std::uint8_t>((std::bit_width(bits) + 7) / 8);
    planes_.resize(std::max(planes_.size(), planes_max * rows));
    split_planes({moved_.data(), rows}, planes_.data(), rows);
  }

  std::size_t at = to.size() + head_bytes;
  to.resize(at + std::size_t{4} * head.planes + rows * head.planes);
  to[at - head_bytes] = static_cast<std::byte>(head.relative);
  to[at - head_bytes + 1] = static_cast<std::byte>(head.planes);
  std::memcpy(&to[at - 8], &head.base, 8);
  std::size_t end = at + std::size_t{4} * head.planes;
  for (std::size_t p = 0; p < head.planes; ++p, at += 4) {
    const std::span<const std::byte> plane(planes_.data() + p * rows, rows);
    auto size = static_cast<std::uint32_t>(choice.noise[p] ? 0 : pack_plane(plane, to.data() + end, rows - 1));
    if (size == 0) {
      size = static_cast<std::uint32_t>(rows);
      std::ranges::copy(plane, to.data() + end);
    }
    std::memcpy(&to[at], &size, 4);
    end += size;
  }
  to.resize(end);
}

bool IntegerBlocks::says_zeros(std::span<const std::byte> from) {
  return from.size() >= head_bytes &&
         std::ranges::all_of(from.first(head_bytes), [](std::byte b) { return b == std::byte{0}; });
}

const char* IntegerBlocks::take(std::span<const std::byte>& from, std::span<std::uint64_t> numbers) {
  const std::size_t rows = numbers.size();
  check(rows > 0 && rows <= block_rows, "a block has 1 to block_rows rows");
  if (from.size() < head_bytes) return "ends too early";
  BlockHead head{static_cast<Relative>(from[0]), static_cast<std::uint8_t>(from[1]), 0};
  if (head.relative > Relative::to_previous || head.planes > planes_max ||
      (head.planes == 0 && head.relative != Relative::to_least))
    return "is coded in an unknown way";
  std::memcpy(&head.base, &from[2], 8);
  if (from.size() < head_bytes + std::size_t{4} * head.planes) return "ends too early";
  const auto sizes = from.subspan(head_bytes, std::size_t{4} * head.planes);
  from = from.subspan(head_bytes + sizes.size());

  std::array<const std::byte*, planes_max> planes{};
  for (std::size_t p = 0; p < head.planes; ++p) {
    std::uint32_t size = 0;
    std::memcpy(&size, &sizes[4 * p], 4);
    if (size == 0 || size > rows || size > from.size()) return "has a plane of a size that it cannot have";
    if (size == rows) {
      planes[p] = from.data();
    } else {
      planes_.resize(std::max(planes_.size(), planes_max * rows));
      const std::span unpacked(planes_.data() + p * rows, rows);
      if (!unpack_plane(from.first(size), unpacked)) return "has a plane that cannot be unpacked";
      planes[p] = unpacked.data();
    }
    from = from.subspan(size);
  }
  if (head.planes > 0) {
    const std::span top(planes[head.planes - 1], rows);
    if (std::ranges::all_of(top, [](std::byte b) { return b == std::byte{0}; }))
      return "has a plane of zeros, which is never written";
  }
  join_planes(std::span<const std::byte* const>(planes).first(head.planes), numbers);
  return move_back(head, numbers);
}

}  // namespace tessera::store
