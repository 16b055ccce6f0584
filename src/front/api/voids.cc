#include "tessera/voids.h"

#include <utility>

#include "src/front/api/errors.h"
#include "src/front/api/options_inside.h"
#include "src/front/api/triangulation_impl.h"
#include "src/job/machine.h"
#include "src/job/version.h"
#include "src/result/voids/voids.h"

namespace tessera {

struct VoidsRequest::Impl {
  voids::VoidsOptions options;  // 0 threads and 0 bytes let the library choose
  std::stop_token stop;
};

VoidsRequest::VoidsRequest() : impl_(std::make_unique<Impl>()) {}
VoidsRequest::VoidsRequest(const VoidsRequest& other) : impl_(std::make_unique<Impl>(*other.impl_)) {}
VoidsRequest& VoidsRequest::operator=(const VoidsRequest& other) {
  *impl_ = *other.impl_;
  return *this;
}
VoidsRequest::~VoidsRequest() = default;

VoidsRequest& VoidsRequest::by(const std::string& density) {
  impl_->options.by = density;
  return *this;
}
VoidsRequest& VoidsRequest::output(const std::filesystem::path& target) {
  impl_->options.target = target;
  return *this;
}
VoidsRequest& VoidsRequest::overwrite(bool overwrite) {
  impl_->options.overwrite = overwrite;
  return *this;
}
VoidsRequest& VoidsRequest::memory_bytes(std::uint64_t bytes) {
  impl_->options.memory_bytes = bytes;
  return *this;
}
VoidsRequest& VoidsRequest::threads(unsigned threads) {
  impl_->options.threads = threads;
  return *this;
}
VoidsRequest& VoidsRequest::stop(std::stop_token stop) {
  impl_->stop = std::move(stop);
  return *this;
}

namespace {

std::vector<FoundVoid> voids_of(const voids::VoidTable& table) {
  std::vector<FoundVoid> all;
  all.reserve(table.rows.size());
  for (const voids::VoidRow& row : table.rows) {
    FoundVoid one{.zone = static_cast<std::int64_t>(row.core.value),
                  .core_density = row.core_density,
                  .x = row.place.x,
                  .y = row.place.y,
                  .z = row.place.z,
                  .zone_points = static_cast<std::int64_t>(row.zone_points),
                  .zone_volume = row.zone_volume,
                  .saddle_density = row.saddle_density,
                  .void_zones = static_cast<std::int64_t>(row.zones),
                  .void_points = static_cast<std::int64_t>(row.points),
                  .void_volume = row.volume,
                  .contrast = row.contrast,
                  .probability = row.probability};
    if (row.saddle) one.saddle_vertex = static_cast<std::int64_t>(row.saddle->value);
    if (row.parent != voids::no_zone) one.parent = static_cast<std::int64_t>(table.rows[row.parent].core.value);
    all.push_back(one);
  }
  return all;
}

}  // namespace

FoundVoids Triangulation::find_voids(const VoidsRequest& request) {
  return guarded([&] {
    const auto& asked = OptionsInside::of(request);
    voids::VoidsOptions options = asked.options;
    if (options.memory_bytes == 0) options.memory_bytes = default_memory();
    if (options.threads == 0) options.threads = usable_processors();
    options.software_version = tessera::version();
    const std::filesystem::path folder = this->folder();
    const auto result = value_or_throw(voids::find_voids(folder, options, asked.stop));
    impl_ =
        std::make_shared<const Impl>(Impl{value_or_throw(TileSource::open(folder, Periods::known)), impl_->temporary});
    return FoundVoids{result.found.column, result.found.made, result.found.outside, voids_of(result.table)};
  });
}

}  // namespace tessera
