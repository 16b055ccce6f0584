// Source: LASzip, design/specification.rst; rapidlasso, LAZ Specification 1.4.
#include "src/input/las_copy/returns_xy_encoder.h"

#include "src/input/bytes/fields.h"

namespace tessera::laz {
namespace {

std::uint32_t channel_of(const std::byte* record) { return std::to_integer<std::uint32_t>(record[15]) >> 4 & 3; }

}  // namespace

ReturnsXyEncoder::ReturnsXyEncoder(const std::byte* first) : current_(channel_of(first)) {
  channels_[current_] = std::make_unique<Channel>();
  channels_[current_]->last = point_of(first);
}

ReturnsXyEncoder::LastPoint ReturnsXyEncoder::point_of(const std::byte* record) {
  const auto returned = std::to_integer<std::uint8_t>(record[14]);
  return {.x = load<std::int32_t>(record),
          .y = load<std::int32_t>(record + 4),
          .returns = static_cast<std::uint8_t>(returned >> 4),
          .number = static_cast<std::uint8_t>(returned & 15),
          .angle = load<std::int16_t>(record + 18),
          .source = load<std::uint16_t>(record + 20),
          .time = load<std::int64_t>(record + 22)};
}

void ReturnsXyEncoder::encode(std::span<PointStep> steps, const std::byte* records, std::size_t stride) {
  for (auto& step : steps) {
    next(step, records);
    records += stride;
  }
}

void ReturnsXyEncoder::next(PointStep& step, const std::byte* record) {
  // The context is that of the point before, whatever its channel.
  const LastPoint& before = channels_[current_]->last;
  const std::uint32_t context = std::uint32_t{before.number == 1} |
                                std::uint32_t{before.number >= before.returns} << 1 |
                                std::uint32_t{last_time_was_new_} << 2;
  const std::uint32_t channel = channel_of(record);
  const LastPoint point = point_of(record), last = channels_[channel] ? channels_[channel]->last : before;
  step.channel = static_cast<std::uint8_t>(channel);
  step.new_channel = channel != current_;
  step.new_source = point.source != last.source;
  step.new_time = last_time_was_new_ = point.time != last.time;
  step.new_angle = point.angle != last.angle;
  step.level = static_cast<std::uint8_t>(return_level(point.returns, point.number));
  step.placement = static_cast<std::uint8_t>((point.number == 1) << 1 | (point.number >= point.returns));
  put_changes(step, point, last, context);
  Channel& c = *channels_[current_];
  put_xy(c, step, point);
  c.last = point;
}

// Encodes what has changed since `last`, and goes to the point's channel.
void ReturnsXyEncoder::put_changes(const PointStep& step, const LastPoint& point, const LastPoint& last,
                                   std::uint32_t context) {
  const std::uint32_t number_moved = (point.number - last.number) & 15u;
  const std::uint32_t number_change = number_moved == 15 ? 2 : number_moved < 2 ? number_moved : 3;
  const bool other_channel = step.channel != current_, other_returns = point.returns != last.returns;
  Channel& left = *channels_[current_];
  encoder_.symbol(left.changes[context], number_change | std::uint32_t{other_returns} << 2 |
                                             std::uint32_t{step.new_angle} << 3 | std::uint32_t{step.new_time} << 4 |
                                             std::uint32_t{step.new_source} << 5 | std::uint32_t{other_channel} << 6);
  if (other_channel) {
    encoder_.symbol(left.next_channel, (step.channel - current_ - 1) & 3);
    current_ = step.channel;
    if (!channels_[current_]) {
      channels_[current_] = std::make_unique<Channel>();
      channels_[current_]->last = last;
    }
  }
  Channel& c = *channels_[current_];
  if (other_returns) encoder_.symbol(c.returns_after[last.returns], point.returns);
  if (number_change != 3) return;
  if (step.new_time) {
    encoder_.symbol(c.number_after[last.number], point.number);
  } else {
    encoder_.symbol(c.number_at_same_time, number_moved - 2);
  }
}

void ReturnsXyEncoder::put_xy(Channel& c, PointStep& step, const LastPoint& point) {
  const bool single = point.returns == 1;
  const std::size_t kind = return_kind_4bit[point.returns][point.number] * 2u + step.new_time;
  const std::int32_t dx = moved(c.last.x, point.x), dy = moved(c.last.y, point.y);
  c.x_differences.next(encoder_, c.dx[kind].value(), dx, single);
  c.dx[kind].add(dx);
  const std::uint32_t x_length = c.x_differences.length();
  c.y_differences.next(encoder_, c.dy[kind].value(), dy, length_context(x_length, 20, single));
  c.dy[kind].add(dy);
  step.z_context = static_cast<std::uint8_t>(length_context((x_length + c.y_differences.length()) / 2, 18, single));
}

}  // namespace tessera::laz
