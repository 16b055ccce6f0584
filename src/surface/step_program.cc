#include "src/surface/step_program.h"

#include <algorithm>
#include <iterator>

namespace tessera::surface {

void StepEnd::store(Stored done) {
  Status written = store_.write(what_, tile_, bytes_);
  done(written ? Result<Receipt>(Receipt()) : Result<Receipt>(std::move(written).error()));
}

Status StepProgram::tell(std::span<const TileId> to) {
  PieceOutbox out;
  BOOST_OUTCOME_TRYV(work_.tell(self_, out));
  auto all = out.take();
  std::copy_if(
      std::make_move_iterator(all.begin()), std::make_move_iterator(all.end()), std::back_inserter(messages_),
      [&](const auto& message) { return to.empty() || std::binary_search(to.begin(), to.end(), message.first); });
  return success();
}

Status StepProgram::begin_settled(Message settled) {
  return told_.load(settled) ? Status(success()) : damaged(self_, "mail");
}

Status StepProgram::take(TileId from, bool, Message message) {
  if (message.empty()) return success();  // the tile's call to itself
  if (!told_.add(from, std::move(message)))
    return error(Errc::internal, "a message between tiles is not a numbered piece of mail");
  return success();
}

Status StepProgram::step() {
  if (reborn_.empty()) return success();
  return tell(std::exchange(reborn_, {}));
}

void StepProgram::replay_to(std::span<const TileId> reborn) {
  std::vector<TileId> all;
  std::set_union(reborn_.begin(), reborn_.end(), reborn.begin(), reborn.end(), std::back_inserter(all));
  reborn_ = std::move(all);
}

Result<bool> StepProgram::load(Image image, ImageOf whose) {
  if (!told_.load(image)) return false;
  if (whose == ImageOf::earlier) {
    BOOST_OUTCOME_TRYV(tell({}));
  }
  return true;
}

void StepProgram::free() {
  told_ = {};
  messages_ = {};
}

Result<std::unique_ptr<Finished>> StepProgram::finish() {
  BOOST_OUTCOME_TRY(bytes, work_.end(self_, told_));
  return std::unique_ptr<Finished>(std::make_unique<StepEnd>(store_, output_of(step_), self_, std::move(bytes)));
}

std::size_t StepProgram::memory() const {
  std::size_t sum = sizeof *this + told_.bytes();
  for (const auto& [to, message] : messages_) sum += message.size();
  return sum;
}

}  // namespace tessera::surface
