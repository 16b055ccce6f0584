#include "tessera/density.h"

#include <limits>
#include <utility>

#include "src/base/files/temporary.h"
#include "src/base/option.h"
#include "src/front/api/errors.h"
#include "src/front/api/options_inside.h"
#include "src/job/machine.h"
#include "src/result/density/density.h"

namespace tessera {

struct DensityRequest::Impl {
  density::GridOptions options = {};  // 0 threads and 0 bytes let the library choose
  std::stop_token stop;

  density::GridOptions chosen() const {
    density::GridOptions all = options;
    if (all.memory_bytes == 0) all.memory_bytes = default_memory();
    if (all.threads == 0) all.threads = usable_processors();
    return all;
  }
  void ask(density::GridKind kind, std::vector<std::string> names) {
    options.kind = kind;
    options.names = std::move(names);
  }
};

DensityRequest::DensityRequest(double res) : impl_(std::make_unique<Impl>()) {
  impl_->options.shape.res = res;
  impl_->options.memory_bytes = 0;
  impl_->options.threads = 0;
}
DensityRequest::DensityRequest(std::span<const std::int64_t> voxels) : DensityRequest(0.0) {
  impl_->options.shape.voxels.assign(voxels.begin(), voxels.end());
}
DensityRequest::DensityRequest(const DensityRequest& other) : impl_(std::make_unique<Impl>(*other.impl_)) {}
DensityRequest& DensityRequest::operator=(const DensityRequest& other) {
  *impl_ = *other.impl_;
  return *this;
}
DensityRequest::~DensityRequest() = default;

DensityRequest& DensityRequest::bbox(std::span<const double> box) {
  guarded([&] {
    if (box.size() != 4 && box.size() != 6)
      or_throw(error(Errc::usage, option("bbox") + ": is a box of 4 numbers in 2D, or 6 in 3D"));
  });
  const std::size_t d = box.size() / 2;
  constexpr double far = std::numeric_limits<double>::infinity();
  impl_->options.shape.box =
      Bounds{{box[0], box[1], d == 3 ? box[2] : -far}, {box[d], box[d + 1], d == 3 ? box[5] : far}};
  return *this;
}
DensityRequest& DensityRequest::mass(const std::string& name) {
  impl_->options.mass = name;
  return *this;
}
DensityRequest& DensityRequest::field(const std::string& name) {
  impl_->ask(density::GridKind::field, {name});
  return *this;
}
DensityRequest& DensityRequest::divergence(const std::vector<std::string>& names) {
  impl_->ask(density::GridKind::divergence, names);
  return *this;
}
DensityRequest& DensityRequest::curl(const std::vector<std::string>& names) {
  impl_->ask(density::GridKind::curl, names);
  return *this;
}
DensityRequest& DensityRequest::shear(const std::vector<std::string>& names) {
  impl_->ask(density::GridKind::shear, names);
  return *this;
}
DensityRequest& DensityRequest::sample(bool sample) {
  impl_->options.sample = sample;
  return *this;
}
DensityRequest& DensityRequest::overwrite(bool overwrite) {
  impl_->options.overwrite = overwrite;
  return *this;
}
DensityRequest& DensityRequest::memory_bytes(std::uint64_t bytes) {
  impl_->options.memory_bytes = bytes;
  return *this;
}
DensityRequest& DensityRequest::threads(unsigned threads) {
  impl_->options.threads = threads;
  return *this;
}
DensityRequest& DensityRequest::stop(std::stop_token stop) {
  impl_->stop = std::move(stop);
  return *this;
}

DensityGrid draw_density(const Triangulation& triangulation, const DensityRequest& request) {
  return guarded([&] {
    const auto& asked = OptionsInside::of(request);
    const density::GridOptions options = asked.chosen();
    const TemporaryFolder scratch = value_or_throw(TemporaryFolder::make());
    auto drawn = value_or_throw(density::draw_grid(triangulation.folder(), scratch.path(), options,
                                                   options.memory_bytes / 2 / sizeof(double), asked.stop));
    const density::GridFacts& facts = drawn.facts;
    DensityGrid grid{.size = {},
                     .origin = {},
                     .components = facts.components,
                     .known = facts.known,
                     .mass = facts.mass.value_or(0),
                     .grid_mass = facts.grid_mass.value_or(0),
                     .note = facts.note,
                     .values = std::move(drawn.values)};
    for (std::size_t axis = 0; axis < static_cast<std::size_t>(facts.dimension); ++axis) {
      grid.size.push_back(facts.size[axis]);
      grid.origin.push_back(facts.origin[axis]);
    }
    return grid;
  });
}

std::vector<double> density_widths(const Triangulation& triangulation, const DensityRequest& request) {
  return guarded([&] {
    const auto grid = value_or_throw(density::grid_of(triangulation.folder(), OptionsInside::of(request).chosen()));
    std::vector<double> widths;
    for (std::size_t axis = 0; axis < static_cast<std::size_t>(grid.dimension); ++axis)
      widths.push_back(grid.axes[axis].width());
    return widths;
  });
}

std::string write_density(const Triangulation& triangulation, const std::filesystem::path& target,
                          const DensityRequest& request) {
  return guarded([&] {
    const auto& asked = OptionsInside::of(request);
    return value_or_throw(density::write_grid(triangulation.folder(), target, asked.chosen(), asked.stop)).facts.note;
  });
}

}  // namespace tessera
