// Source: LASzip, design/specification.rst; rapidlasso, LAZ Specification 1.4.
#include "src/input/laz/returns_xy_layer.h"

#include <cstring>
#include <utility>

#include "src/input/bytes/fields.h"

namespace tessera::laz {

ReturnsXyLayer::ReturnsXyLayer(ByteFeed feed, const std::byte* first)
    : decoder_(std::move(feed)), current_(std::to_integer<unsigned>(first[15]) >> 4 & 3) {
  channels_[current_] = std::make_unique<Channel>();
  auto& c = *channels_[current_];
  c.x = load<std::int32_t>(first);
  c.y = load<std::int32_t>(first + 4);
  c.number = std::to_integer<std::uint8_t>(first[14]) & 15;
  c.returns = std::to_integer<std::uint8_t>(first[14]) >> 4;
}

void ReturnsXyLayer::decode(std::span<PointStep> steps, std::byte* records, std::size_t stride) {
  for (auto& step : steps) {
    next(step, records);
    records += stride;
  }
}

void ReturnsXyLayer::enter_channel(std::uint32_t channel) {
  auto& entered = channels_[channel];
  if (!entered) {
    const auto& left = *channels_[current_];
    entered = std::make_unique<Channel>();
    entered->x = left.x;
    entered->y = left.y;
    entered->returns = left.returns;
    entered->number = left.number;
  }
  current_ = channel;
}

void ReturnsXyLayer::next(PointStep& step, std::byte* record) {
  // The context is that of the point before, whatever its channel.
  const auto& before = *channels_[current_];
  const std::uint32_t context = (before.number == 1) | (before.number >= before.returns) << 1 | last_time_was_new_ << 2;
  const std::uint32_t changes = decoder_.symbol(channels_[current_]->changes[context]);
  step.new_channel = (changes & 64) != 0;
  if (step.new_channel) enter_channel((current_ + decoder_.symbol(channels_[current_]->next_channel) + 1) & 3);
  Channel& c = *channels_[current_];
  step.channel = static_cast<std::uint8_t>(current_);
  step.new_source = (changes & 32) != 0;
  step.new_time = last_time_was_new_ = (changes & 16) != 0;
  step.new_angle = (changes & 8) != 0;

  const std::uint32_t last_number = c.number;
  if ((changes & 4) != 0) c.returns = static_cast<std::uint8_t>(decoder_.symbol(c.returns_after[c.returns]));
  switch (changes & 3) {
    case 0:
      break;
    case 1:
      c.number = (last_number + 1) & 15;
      break;
    case 2:
      c.number = (last_number + 15) & 15;
      break;
    default:
      c.number = step.new_time ? static_cast<std::uint8_t>(decoder_.symbol(c.number_after[last_number]))
                               : (last_number + decoder_.symbol(c.number_at_same_time) + 2) & 15;
  }
  step.level = static_cast<std::uint8_t>(return_level(c.returns, c.number));
  step.placement = static_cast<std::uint8_t>((c.number == 1) << 1 | (c.number >= c.returns));

  const bool single = c.returns == 1;
  const std::size_t kind = return_kind_4bit[c.returns][c.number] * 2u + step.new_time;
  const std::int32_t dx = c.x_differences.next(decoder_, c.dx[kind].value(), single);
  c.dx[kind].add(dx);
  c.x = wrapping_add(c.x, dx);
  const std::uint32_t x_length = c.x_differences.length();
  const std::int32_t dy = c.y_differences.next(decoder_, c.dy[kind].value(), length_context(x_length, 20, single));
  c.dy[kind].add(dy);
  c.y = wrapping_add(c.y, dy);
  step.z_context = static_cast<std::uint8_t>(length_context((x_length + c.y_differences.length()) / 2, 18, single));

  std::memcpy(record, &c.x, sizeof c.x);
  std::memcpy(record + 4, &c.y, sizeof c.y);
  record[14] = static_cast<std::byte>(c.returns << 4 | c.number);
  record[15] = static_cast<std::byte>(current_ << 4);
}

}  // namespace tessera::laz
