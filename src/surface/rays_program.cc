#include "src/surface/rays_program.h"

#include <algorithm>
#include <map>

#include "src/base/flat_codec.h"
#include "src/base/stopped.h"
#include "src/exchange/update.h"
#include "src/surface/ray_caster.h"
#include "src/surface/step_program.h"

namespace tessera::surface {

namespace {

constexpr std::size_t rays_a_message = 1500;
static_assert(rays_a_message * sizeof(RayRecord) < message_bytes_max);

}  // namespace

Status RaysProgram::begin() {
  free();  // of the content of an image that could not be read
  BOOST_OUTCOME_TRY(tile, store_.take(self_));
  tile_ = std::move(tile);
  tile_->begin_weights();
  sums_ = {};
  return cast();
}

Status RaysProgram::cast() {
  BOOST_OUTCOME_TRY(median, sigma_of(*input_, store_));
  std::vector<double> scales;
  if (input_->options.energy.sigma == 0) {
    BOOST_OUTCOME_TRY(bytes, store_.read(StepOutput::own_scales, self_));
    FlatReader in(bytes);
    if (!in.list(scales) || scales.size() != static_cast<std::size_t>(tile_->own_vertices()))
      return damaged(self_, "scales");
  }
  RayCaster caster(*tile_, input_->options.energy, input_->cells);
  const StoredTile& stored = tile_->stored();
  const std::size_t width = row_bytes(stored.schema);
  for (std::int32_t v = 0; v < tile_->own_vertices(); ++v) {
    if (v % 4096 == 0) throw_if_stopped(input_->stop);
    const auto at = static_cast<std::size_t>(v);
    const std::byte* row = stored.rows.data() + at * width;
    BOOST_OUTCOME_TRY(sensor, input_->sensors.of(tile_->point(v), tile_->id(v), row));
    if (!sensor) {
      ++sums_.no_rays;
      continue;
    }
    ++sums_.rays;
    sums_.guessed += sensor->guessed ? 1 : 0;
    // Sparse and dense places have their own scale, but within bounds: with an outlier's scale a ray would reach
    // through everything.
    const double sigma = scales.empty() ? median : std::clamp(scales[at], median / 4, median * 4);
    BOOST_OUTCOME_TRYV(caster.cast(v, sensor->at, sigma, input_->solidity.vote(row)));
  }
  send(caster);
  return success();
}

void RaysProgram::send(RayCaster& caster) {
  for (auto& [to, ray] : caster.take_leaving()) sent_.push_back({ray, to});
  sums_.steps += caster.steps();
}

Status RaysProgram::take(TileId, bool, Message message) {
  if (message.size() % sizeof(RayRecord) != 0)
    return error(Errc::internal, "a message between tiles is not a list of rays");
  FlatReader in(message);
  RayRecord ray;
  while (in.value(ray))
    if (known_.insert({ray.of, ray.steps, ray.behind}).second) waiting_.push_back(ray);
  return success();
}

Status RaysProgram::step() {
  if (waiting_.empty()) return success();
  BOOST_OUTCOME_TRYV(wake());
  RayCaster caster(*tile_, input_->options.energy, input_->cells);
  sums_.handed_over += waiting_.size();
  for (const RayRecord& ray : std::exchange(waiting_, {})) {
    BOOST_OUTCOME_TRYV(caster.go_on(ray));
  }
  send(caster);
  return success();
}

std::vector<std::pair<TileId, Message>> RaysProgram::messages() {
  std::map<TileId, std::vector<std::size_t>> by_tile;
  for (const std::size_t i : std::exchange(again_, {})) by_tile[sent_[i].to].push_back(i);
  for (; told_ < sent_.size(); ++told_) by_tile[sent_[told_].to].push_back(told_);
  std::vector<std::pair<TileId, Message>> messages;
  for (const auto& [to, rays] : by_tile) {
    for (std::size_t begin = 0; begin < rays.size(); begin += rays_a_message) {
      FlatWriter out;
      for (std::size_t i = begin; i < std::min(begin + rays_a_message, rays.size()); ++i) out.value(sent_[rays[i]].ray);
      messages.emplace_back(to, out.take());
    }
  }
  return messages;
}

void RaysProgram::replay_to(std::span<const TileId> reborn) {
  for (std::size_t i = 0; i < told_; ++i)
    if (std::binary_search(reborn.begin(), reborn.end(), sent_[i].to)) again_.push_back(i);
  std::sort(again_.begin(), again_.end());
  again_.erase(std::unique(again_.begin(), again_.end()), again_.end());
}

Status RaysProgram::wake() {
  if (tile_) return success();
  BOOST_OUTCOME_TRY(tile, store_.take(self_));
  tile_ = std::move(tile);
  return tile_->put_weights(std::exchange(put_aside_, {}));
}

Status RaysProgram::put_aside() {
  if (!tile_) return success();
  put_aside_ = tile_->take_weights();
  return store_.give_back(std::move(tile_));
}

Image RaysProgram::save() {
  FlatWriter out;
  out.list(bytes_of(KeptRays{sums_, std::exchange(put_aside_, {})}));
  out.list(std::vector<Known>(known_.begin(), known_.end()));
  out.list(waiting_);
  out.list(sent_);
  return out.take();
}

Result<bool> RaysProgram::load(Image image, ImageOf whose) {
  FlatReader in(image);
  Bytes rays;
  KeptRays kept;
  std::vector<Known> known;
  if (!in.list(rays) || !read(rays, kept) || !in.list(known) || !in.list(waiting_) || !in.list(sent_) || !in.at_end())
    return false;
  sums_ = kept.counts;
  put_aside_ = std::move(kept.weights);
  known_ = {known.begin(), known.end()};
  told_ = whose == ImageOf::earlier ? 0 : sent_.size();
  return true;
}

void RaysProgram::free() {
  tile_.reset();
  put_aside_ = {};
  known_ = {};
  waiting_ = {};
  sent_ = {};
  again_ = {};
  told_ = 0;
}

Message RaysProgram::settled() const { return bytes_of(KeptRays{sums_, weights()}); }

SurfaceTile::Weights RaysProgram::weights() const { return tile_ ? tile_->weights() : put_aside_; }

Status RaysProgram::begin_settled(Message settled) {
  KeptRays kept;
  if (!read(settled, kept)) return damaged(self_, "rays");
  sums_ = kept.counts;
  put_aside_ = std::move(kept.weights);
  return success();
}

Result<std::unique_ptr<Finished>> RaysProgram::finish() {
  BOOST_OUTCOME_TRYV(put_aside());
  BOOST_OUTCOME_TRYV(store_.write(StepOutput::ray_counts, self_, bytes_of(sums_)));
  return std::unique_ptr<Finished>(std::make_unique<StepEnd>(store_, StepOutput::rays, self_,
                                                             bytes_of(KeptRays{sums_, std::exchange(put_aside_, {})})));
}

std::size_t RaysProgram::memory() const {
  return sizeof *this + (tile_ ? tile_->bytes() : put_aside_.arcs.size() * 4 + put_aside_.excess.size() * 8) +
         known_.size() * 80 + (waiting_.size() + sent_.size()) * sizeof(Sent);
}

}  // namespace tessera::surface
