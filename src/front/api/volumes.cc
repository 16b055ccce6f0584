#include "tessera/volumes.h"

#include <optional>
#include <utility>

#include "src/front/api/errors.h"
#include "src/front/api/options_inside.h"
#include "src/front/api/surface_request_inside.h"
#include "src/result/volume/difference.h"
#include "src/result/volume/volumes.h"

namespace tessera {

template <>
struct AskedOfEngine<VolumeRequest> {
  using Options = VolumeOptions;
};
template class SurfaceRequest<VolumeRequest>;

VolumeRequest::VolumeRequest() = default;
VolumeRequest& VolumeRequest::plane(double height) {
  impl_->options.plane = height;
  return *this;
}
VolumeRequest& VolumeRequest::base(const std::filesystem::path& file) {
  impl_->options.base = file;
  return *this;
}
VolumeRequest& VolumeRequest::within(const std::filesystem::path& file) {
  impl_->options.within = file;
  return *this;
}
VolumeRequest& VolumeRequest::name(const std::string& attribute) {
  impl_->options.name = attribute;
  return *this;
}
VolumeRequest& VolumeRequest::threads(unsigned threads) {
  impl_->options.threads = threads;
  return *this;
}

namespace {

using Second = std::optional<std::filesystem::path>;

VolumeTable table_of(const Triangulation& a, const Second& b, const VolumeRequest& request) {
  return guarded([&] {
    const auto& asked = OptionsInside::of(request);
    auto made = value_or_throw(volumes(a.folder(), b, asked.chosen(), asked.stop));
    VolumeTable table;
    for (VolumeRow& row : made.rows) {
      if (row.feature) table.polygons.push_back(*row.feature);
      if (row.feature) table.names.push_back(std::move(row.name));
      table.cut.push_back(row.cut);
      table.fill.push_back(row.fill);
      table.net.push_back(row.net);
      table.mean.push_back(row.mean);
      table.area.push_back(row.area);
      table.covered.push_back(row.covered);
      table.uncovered.push_back(row.uncovered);
      table.uncovered_by_a.push_back(row.uncovered_by_a);
      table.uncovered_by_b.push_back(row.uncovered_by_b);
    }
    table.area_unit = std::move(made.area_unit);
    table.volume_unit = std::move(made.volume_unit);
    table.note = std::move(made.note);
    return table;
  });
}

void write_raster_of(const Triangulation& a, const Second& b, const std::filesystem::path& target, double res,
                     const VolumeRequest& request) {
  guarded([&] {
    const auto& asked = OptionsInside::of(request);
    return value_or_throw(write_difference(a.folder(), b, target, res, asked.overwrite, asked.chosen(), asked.stop))
        .bytes;
  });
}

}  // namespace

VolumeTable compute_volumes(const Triangulation& a, const Triangulation& b, const VolumeRequest& request) {
  return table_of(a, b.folder(), request);
}
VolumeTable compute_volumes(const Triangulation& a, const VolumeRequest& request) {
  return table_of(a, std::nullopt, request);
}
void write_difference_raster(const Triangulation& a, const Triangulation& b, const std::filesystem::path& target,
                             double res, const VolumeRequest& request) {
  write_raster_of(a, b.folder(), target, res, request);
}
void write_difference_raster(const Triangulation& a, const std::filesystem::path& target, double res,
                             const VolumeRequest& request) {
  write_raster_of(a, std::nullopt, target, res, request);
}

}  // namespace tessera
