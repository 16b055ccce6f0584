// Binds rasters, contour lines, profiles and densities of results, regions of raw clouds, and heights above the ground.
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <optional>
#include <utility>

#include "python/bindings/bindings.h"
#include "python/bindings/interruptible.h"
#include "python/bindings/views.h"
#include "tessera/density.h"
#include "tessera/heights.h"
#include "tessera/lines.h"
#include "tessera/raster.h"
#include "tessera/region.h"

namespace tessera::python {
namespace {

// `method` is the place of its name in the list of _surfaces.py.
RasterRequest raster_request(double res, const std::optional<std::array<double, 4>>& bbox,
                             std::optional<double> max_edge, std::optional<double> max_radius, const std::string& value,
                             bool doubles, const std::optional<std::pair<double, double>>& light, int method) {
  RasterRequest request(res);
  request.method(method == 0 ? RasterMethod::linear : method == 1 ? RasterMethod::natural : RasterMethod::laplace);
  if (bbox) request.bbox(*bbox);
  if (max_edge) request.max_edge(*max_edge);
  if (max_radius) request.max_radius(*max_radius);
  if (light) request.hillshade(light->first, light->second);
  request.value(value).doubles(doubles);
  return request;
}

// Returns (height x width array, left, top).
py::tuple draw(const Triangulation& self, RasterRequest request) {
  auto* raster = new Raster;
  const py::capsule owner(raster, [](void* memory) { delete static_cast<Raster*>(memory); });
  *raster = run_interruptible([&](std::stop_token stop) { return draw_raster(self, request.stop(std::move(stop))); });
  return py::make_tuple(
      py::array(py::dtype::of<double>(), {raster->height, raster->width}, raster->values.data(), owner), raster->left,
      raster->top);
}

std::string write(const Triangulation& self, const std::filesystem::path& target, RasterRequest request,
                  bool overwrite) {
  request.overwrite(overwrite);
  return run_interruptible(
      [&](std::stop_token stop) { return write_raster(self, target, request.stop(std::move(stop))); });
}

ContourRequest contour_request(double interval, double base, const std::optional<std::array<double, 4>>& bbox,
                               std::optional<double> max_edge, std::optional<double> max_radius,
                               const std::string& value, std::optional<double> smooth, std::optional<double> min_length,
                               std::uint32_t index_every) {
  ContourRequest request(interval);
  if (bbox) request.bbox(*bbox);
  if (max_edge) request.max_edge(*max_edge);
  if (max_radius) request.max_radius(*max_radius);
  if (smooth) request.smooth(*smooth);
  if (min_length) request.min_length(*min_length);
  request.value(value).base(base).index_every(index_every);
  return request;
}

// Returns (values, offsets, n x 2 points, flags of index lines).
py::tuple contours(const Triangulation& self, ContourRequest request) {
  auto lines =
      run_interruptible([&](std::stop_token stop) { return draw_contours(self, request.stop(std::move(stop))); });
  return py::make_tuple(given<double>(std::move(lines.values)), given<std::int64_t>(std::move(lines.offsets)),
                        rows<double>(std::move(lines.points), 2), given<std::uint8_t>(std::move(lines.index)));
}

std::string write_lines(const Triangulation& self, const std::filesystem::path& target, ContourRequest request,
                        bool overwrite) {
  request.overwrite(overwrite);
  return run_interruptible(
      [&](std::stop_token stop) { return write_contours(self, target, request.stop(std::move(stop))); });
}

// `digits`: no value means the precision of the data, a number below 0 all digits.
ProfileRequest profile_request(std::optional<double> max_edge, std::optional<double> max_radius,
                               const std::string& value, std::optional<int> digits) {
  ProfileRequest request;
  if (digits && *digits < 0) request.all_digits();
  if (digits && *digits >= 0) request.digits(*digits);
  if (max_edge) request.max_edge(*max_edge);
  if (max_radius) request.max_radius(*max_radius);
  request.value(value);
  return request;
}

// Returns (distances, n x 2 points, values, parts).
py::tuple profile(const Triangulation& self, const Coordinates& line, ProfileRequest request) {
  const auto span = span_of(line);
  auto table =
      run_interruptible([&](std::stop_token stop) { return draw_profile(self, span, request.stop(std::move(stop))); });
  return py::make_tuple(given<double>(std::move(table.distances)), rows<double>(std::move(table.points), 2),
                        given<double>(std::move(table.values)), given<std::int64_t>(std::move(table.parts)));
}

std::string write_table(const Triangulation& self, const Coordinates& line, const std::filesystem::path& target,
                        ProfileRequest request, bool overwrite) {
  request.overwrite(overwrite);
  const auto span = span_of(line);
  return run_interruptible(
      [&](std::stop_token stop) { return write_profile(self, span, target, request.stop(std::move(stop))); });
}

DensityRequest density_request(double res, const std::vector<std::int64_t>& voxels, const std::vector<double>& bbox,
                               const std::string& kind, const std::vector<std::string>& names, const std::string& mass,
                               bool sample, std::uint64_t memory_bytes, unsigned threads) {
  DensityRequest request = voxels.empty() ? DensityRequest(res) : DensityRequest(voxels);
  if (!bbox.empty()) request.bbox(bbox);
  if (kind == "field") request.field(names.front());
  if (kind == "divergence") request.divergence(names);
  if (kind == "curl") request.curl(names);
  if (kind == "shear") request.shear(names);
  request.mass(mass).sample(sample).memory_bytes(memory_bytes).threads(threads);
  return request;
}

// Returns (array, origin, widths, mass, mass of the grid, note).
py::tuple density(const Triangulation& self, DensityRequest request) {
  const auto widths = density_widths(self, request);
  auto* grid = new DensityGrid;
  const py::capsule owner(grid, [](void* memory) { delete static_cast<DensityGrid*>(memory); });
  *grid = run_interruptible([&](std::stop_token stop) { return draw_density(self, request.stop(std::move(stop))); });
  std::vector<py::ssize_t> shape(grid->size.rbegin(), grid->size.rend());
  if (grid->components > 1) shape.push_back(static_cast<py::ssize_t>(grid->components));
  return py::make_tuple(py::array(py::dtype::of<double>(), shape, grid->values.data(), owner),
                        py::tuple(py::cast(grid->origin)), py::tuple(py::cast(widths)), grid->mass, grid->grid_mass,
                        grid->note);
}

std::string write_grid(const Triangulation& self, const std::filesystem::path& target, DensityRequest request,
                       bool overwrite) {
  request.overwrite(overwrite);
  return run_interruptible(
      [&](std::stop_token stop) { return write_density(self, target, request.stop(std::move(stop))); });
}

Triangulation region(const std::vector<std::string>& inputs, const std::vector<double>& box,
                     TriangulationOptions options, const RegionRequest& request, const py::object& warn) {
  std::vector<std::string> warnings;
  options.warning([&](const std::string& sentence) { warnings.push_back(sentence); });
  auto made = run_interruptible(
      [&](std::stop_token stop) { return triangulate_region(inputs, box, options.stop(std::move(stop)), request); });
  for (const auto& sentence : warnings) warn(sentence);
  return made;
}

// Returns a list of (input, output, points, outside).
py::list heights(const std::vector<std::string>& inputs, const std::filesystem::path& folder, HeightsRequest request) {
  const auto copies = run_interruptible(
      [&](std::stop_token stop) { return write_heights(inputs, folder, request.stop(std::move(stop))); });
  py::list list;
  for (const auto& copy : copies) list.append(py::make_tuple(copy.input, copy.output, copy.points, copy.outside));
  return list;
}

}  // namespace

void bind_surfaces(py::module_& module) {
  py::class_<RasterRequest>(module, "RasterRequest").def(py::init(&raster_request));
  module.def("draw_raster", &draw);
  module.def("write_raster", &write);
  py::class_<ContourRequest>(module, "ContourRequest").def(py::init(&contour_request));
  module.def("draw_contours", &contours);
  module.def("write_contours", &write_lines);
  py::class_<ProfileRequest>(module, "ProfileRequest").def(py::init(&profile_request));
  module.def("draw_profile", &profile);
  module.def("write_profile", &write_table);
  py::class_<DensityRequest>(module, "DensityRequest").def(py::init(&density_request));
  module.def("draw_density", &density);
  module.def("write_density", &write_grid);
  py::class_<RegionRequest>(module, "RegionRequest")
      .def(py::init<>())
      .def("scan_files", [](RegionRequest& self, bool scan) { self.scan_files(scan); })
      .def("max_points", [](RegionRequest& self, std::uint64_t points) { self.max_points(points); })
      .def("max_seconds", [](RegionRequest& self, double seconds) { self.max_seconds(seconds); });
  module.def("triangulate_region", &region);
  py::class_<HeightsRequest>(module, "HeightsRequest")
      .def(py::init<>())
      .def("ground", [](HeightsRequest& self, const std::filesystem::path& result) { self.ground(result); })
      .def("ground_class", [](HeightsRequest& self, int number) { self.ground_class(number); })
      .def("format", [](HeightsRequest& self, const std::string& name) { self.format(name); })
      .def("outside", [](HeightsRequest& self, double height) { self.outside(height); })
      .def("replace", [](HeightsRequest& self, bool replace) { self.replace(replace); })
      .def("overwrite", [](HeightsRequest& self, bool overwrite) { self.overwrite(overwrite); })
      .def("memory_bytes", [](HeightsRequest& self, std::uint64_t bytes) { self.memory_bytes(bytes); })
      .def("threads", [](HeightsRequest& self, unsigned threads) { self.threads(threads); });
  module.def("write_heights", &heights);
}

}  // namespace tessera::python
