#include "src/result/density/array_files.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstring>
#include <span>
#include <utility>

#include "src/base/files/descriptor.h"
#include "src/base/files/fits_cards.h"
#include "src/base/files/names.h"
#include "src/base/files/temporary.h"
#include "src/base/files/whole_file.h"
#include "src/base/hdf5/hdf5_output.h"
#include "src/result/measure/tile_measure.h"
#include "src/result/store/stamp.h"

namespace tessera::density {

namespace fs = std::filesystem;

namespace {

// A file that is written at any place, and appears whole or not at all.
class PlacedFile {
 public:
  static Result<PlacedFile> create(const fs::path& target, std::uint64_t bytes) {
    TemporaryFile temporary(temporary_name(target));
    BOOST_OUTCOME_TRY(file, open_handle(temporary.path(), O_RDWR | O_CREAT | O_TRUNC, target));
    if (::ftruncate(file.get(), static_cast<off_t>(bytes)) != 0) return io_error(target, "cannot write", errno);
    return PlacedFile(target, std::move(temporary), std::move(file));
  }
  Status write(std::uint64_t at, std::span<const std::byte> bytes) const {
    return write_at(file_.get(), bytes, at, target_);
  }
  Status write(std::uint64_t at, const std::string& text) const { return write(at, std::as_bytes(std::span(text))); }
  Result<std::uint64_t> commit() {
    BOOST_OUTCOME_TRY(bytes, size_of(file_, target_));
    BOOST_OUTCOME_TRYV(publish(temporary_.path(), target_));
    temporary_.keep();
    BOOST_OUTCOME_TRYV(sync_folder(target_.parent_path()));
    return bytes;
  }

 private:
  PlacedFile(fs::path target, TemporaryFile temporary, FileHandle file)
      : target_(std::move(target)), temporary_(std::move(temporary)), file_(std::move(file)) {}
  fs::path target_;
  TemporaryFile temporary_;
  FileHandle file_;
};

std::uint64_t voxels_of(const GridRequest& request) { return static_cast<std::uint64_t>(request.grid.voxels()); }

// Calls take(component, place, values) with the values of one component, in runs along x; `place` is the number of the
// first voxel.
template <class Take>
Status for_each_component_run(const GridRequest& request, const GridOptions& options, Gridding& gridding,
                              const Take& take) {
  const std::size_t components = request.quantity.components();
  std::vector<double> run;
  return gridding.for_each_run(options.memory_bytes / 4,
                               [&](std::uint64_t place, std::span<const double> values) -> Status {
                                 for (std::size_t c = 0; c < components; ++c) {
                                   run.resize(values.size() / components);
                                   for (std::size_t i = 0; i < run.size(); ++i) run[i] = values[i * components + c];
                                   BOOST_OUTCOME_TRYV(take(c, place / components, std::span<double>(run)));
                                 }
                                 return success();
                               });
}

// {'descr': '<f8', 'fortran_order': False, 'shape': (2, 3), }
std::string npy_head(const VoxelGrid& grid, std::size_t components) {
  std::string shape;
  for (int axis = grid.dimension - 1; axis >= 0; --axis)
    shape += std::to_string(grid.size[static_cast<std::size_t>(axis)]) + ", ";
  if (components > 1) shape += std::to_string(components) + ", ";
  shape.resize(shape.size() - 2);
  constexpr std::size_t bytes = 128, before = 10;
  std::string head("\x93NUMPY\x01\x00\x76\x00", before);
  head += "{'descr': '<f8', 'fortran_order': False, 'shape': (" + shape + "), }";
  head.resize(bytes - 1, ' ');
  return head + "\n";
}

Hdf5Layout hdf5_layout(const GridRequest& request, const GridLabels& labels) {
  const VoxelGrid& grid = request.grid;
  const auto d = static_cast<std::size_t>(grid.dimension);
  std::vector<double> origin, res, period;
  std::vector<std::int64_t> size;
  std::vector<std::uint64_t> shape;
  for (std::size_t axis = 0; axis < d; ++axis) {
    origin.push_back(grid.axes[axis].plane(grid.first[axis]).at);
    res.push_back(grid.axes[axis].width());
    size.push_back(grid.size[axis]);
    period.push_back(request.source.period().length[axis]);
    shape.push_back(static_cast<std::uint64_t>(grid.size[d - 1 - axis]));
  }
  Hdf5Layout layout{.attributes = {{"origin", origin}, {"res", res}, {"size", size}, {"period", period}}};
  const ResultStamp stamp = stamp_of(request.source.manifest());
  layout.attributes.push_back({"made_by", std::string("tessera density")});
  layout.attributes.push_back({"version", std::vector<std::int64_t>{stamp.version}});
  if (!stamp.digest.empty()) layout.attributes.push_back({"digest", stamp.digest});
  for (const auto& name : labels.names) {
    layout.tables.push_back({.name = name, .shape = shape, .attributes = {{"description", labels.about}}});
    if (!labels.unit.empty()) layout.tables.back().attributes.push_back({"unit", labels.unit});
  }
  return layout;
}

// The axes of an image, its coordinates and what it is of.
void add_image_cards(FitsCards& cards, const GridRequest& request, const GridLabels& labels) {
  constexpr std::array<const char*, 3> names{"X", "Y", "Z"};
  const VoxelGrid& grid = request.grid;
  if (!labels.unit.empty()) cards.text("BUNIT", labels.unit);
  cards.text("OBJECT", labels.about);
  const std::string unit = unit_of(request.source.manifest(), 1);
  for (std::size_t axis = 0; axis < static_cast<std::size_t>(grid.dimension); ++axis) {
    const std::string number = std::to_string(axis + 1);
    // Pixel 1 reaches from 0.5 to 1.5.
    cards.text("CTYPE" + number, names[axis]);
    cards.real("CRPIX" + number, 0.5);
    cards.real("CRVAL" + number, grid.axes[axis].plane(grid.first[axis]).at);
    cards.real("CDELT" + number, grid.axes[axis].width());
    if (!unit.empty()) cards.text("CUNIT" + number, unit);
    cards.real("PERIOD" + number, request.source.period().length[axis]);
  }
  cards.text("CREATOR", "tessera density");
  cards.comment(comment_of(stamp_of(request.source.manifest())));
}

void add_size_cards(FitsCards& cards, const VoxelGrid& grid) {
  cards.whole("BITPIX", -64);
  cards.whole("NAXIS", grid.dimension);
  for (std::size_t axis = 0; axis < static_cast<std::size_t>(grid.dimension); ++axis)
    cards.whole("NAXIS" + std::to_string(axis + 1), static_cast<std::uint64_t>(grid.size[axis]));
}

// The headers of a FITS file, one for each component. Of several, the first begins with a header without an image.
std::vector<std::string> fits_heads(const GridRequest& request, const GridLabels& labels) {
  std::vector<std::string> heads;
  FitsCards cards;
  if (labels.names.size() == 1) {
    cards.flag("SIMPLE", true);
    add_size_cards(cards, request.grid);
    add_image_cards(cards, request, labels);
    return {cards.end()};
  }
  cards.flag("SIMPLE", true);
  cards.whole("BITPIX", 8);
  cards.whole("NAXIS", 0);
  cards.flag("EXTEND", true);
  std::string before = cards.end();
  for (const auto& name : labels.names) {
    cards.text("XTENSION", "IMAGE");
    add_size_cards(cards, request.grid);
    cards.whole("PCOUNT", 0);
    cards.whole("GCOUNT", 1);
    cards.text("EXTNAME", name);
    add_image_cards(cards, request, labels);
    heads.push_back(std::exchange(before, {}) + cards.end());
  }
  return heads;
}

void swap_bytes(std::span<double> values) {
  static_assert(std::endian::native == std::endian::little);
  for (double& value : values) {
    std::uint64_t bits = 0;
    std::memcpy(&bits, &value, sizeof bits);
    bits = __builtin_bswap64(bits);
    std::memcpy(&value, &bits, sizeof bits);
  }
}

std::string kind_name(const GridOptions& options) {
  switch (options.kind) {
    case GridKind::density:
      return "density";
    case GridKind::field:
      return options.names.front();
    case GridKind::divergence:
      return "divergence";
    case GridKind::curl:
      return "curl";
    case GridKind::shear:
      break;
  }
  return "shear";
}

}  // namespace

GridLabels labels_of(const GridRequest& request, const GridOptions& options) {
  GridLabels labels;
  const int dimension = request.grid.dimension;
  std::string name = kind_name(options), of = options.mass;
  if (is_of_vector(options.kind))
    for (const auto& each : options.names) of += (of.empty() ? "" : ",") + each;
  labels.about = name + (of.empty() ? "" : " of " + of);
  // HDF5 has groups in names with slashes.
  std::replace(name.begin(), name.end(), '/', '_');
  for (std::size_t c = 0; c < request.quantity.components(); ++c)
    labels.names.push_back(name + component_suffix(options.kind, dimension, c));
  const Manifest& manifest = request.source.manifest();
  if (options.kind == GridKind::density && options.mass.empty()) {
    const std::string volume = unit_of(manifest, dimension);
    if (!volume.empty()) labels.unit = "1/" + volume;
  }
  if (options.kind == GridKind::field)
    for (const Attribute& attribute : manifest.schema)
      if (attribute.name == options.names.front()) labels.unit = attribute.unit;
  return labels;
}

Result<std::uint64_t> write_npy(const fs::path& target, const GridRequest& request, const GridOptions& options,
                                Gridding& gridding) {
  const std::string head = npy_head(request.grid, request.quantity.components());
  const std::uint64_t bytes = voxels_of(request) * request.quantity.components() * sizeof(double);
  BOOST_OUTCOME_TRY(file, PlacedFile::create(target, head.size() + bytes));
  BOOST_OUTCOME_TRYV(file.write(0, head));
  BOOST_OUTCOME_TRYV(
      gridding.for_each_run(options.memory_bytes / 4, [&](std::uint64_t place, std::span<const double> values) {
        return file.write(head.size() + place * sizeof(double), std::as_bytes(values));
      }));
  return file.commit();
}

Result<std::uint64_t> write_hdf5(const fs::path& target, const GridRequest& request, const GridOptions& options,
                                 Gridding& gridding) {
  BOOST_OUTCOME_TRY(file, Hdf5Output::create(target, hdf5_layout(request, labels_of(request, options))));
  BOOST_OUTCOME_TRYV(for_each_component_run(
      request, options, gridding, [&](std::size_t component, std::uint64_t place, std::span<const double> values) {
        return file.write(component, place, std::as_bytes(values));
      }));
  return file.commit();
}

Result<std::uint64_t> write_fits(const fs::path& target, const GridRequest& request, const GridOptions& options,
                                 Gridding& gridding) {
  const auto heads = fits_heads(request, labels_of(request, options));
  std::vector<std::uint64_t> places;  // of the values of each component
  std::uint64_t end = 0;
  for (const auto& head : heads) {
    places.push_back(end + head.size());
    end = places.back() + fits_blocks_of(voxels_of(request) * sizeof(double));
  }
  BOOST_OUTCOME_TRY(file, PlacedFile::create(target, end));
  for (std::size_t c = 0; c < heads.size(); ++c) {
    BOOST_OUTCOME_TRYV(file.write(places[c] - heads[c].size(), heads[c]));
  }
  BOOST_OUTCOME_TRYV(for_each_component_run(
      request, options, gridding, [&](std::size_t component, std::uint64_t place, std::span<double> values) {
        swap_bytes(values);
        return file.write(places[component] + place * sizeof(double), std::as_bytes(values));
      }));
  return file.commit();
}

}  // namespace tessera::density
