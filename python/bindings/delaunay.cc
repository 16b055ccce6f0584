#include "tessera/delaunay.h"

#include <algorithm>
#include <memory>

#include "python/bindings/bindings.h"
#include "python/bindings/interruptible.h"
#include "python/bindings/simplices.h"
#include "python/bindings/views.h"
#include "python/bindings/weights.h"

namespace tessera::python {
namespace {

std::unique_ptr<Delaunay> triangulate_in_memory(const Coordinates& points) {
  const auto coordinates = span_of(points);
  const auto dimension = static_cast<int>(points.shape(1));
  const auto work = [&](std::stop_token stop) {
    return std::make_unique<Delaunay>(coordinates, dimension, std::move(stop));
  };
  // A small triangulation takes some milliseconds at most, so Ctrl-C can wait, and a thread would cost more.
  constexpr py::ssize_t small = 2000;
  return points.shape(0) <= small ? work({}) : run_interruptible(work);
}

Indices find_simplex(const Delaunay& delaunay, const Coordinates& queries) {
  constexpr std::size_t chunk = 1 << 14;  // some milliseconds of work between two questions for Ctrl-C
  const auto dimension = static_cast<std::size_t>(delaunay.dimension());
  const auto from = span_of(queries);
  Indices found(static_cast<py::ssize_t>(from.size() / dimension));
  const std::span<std::int32_t> to{found.mutable_data(), static_cast<std::size_t>(found.size())};
  for (std::size_t begin = 0; begin < to.size(); begin += chunk) {
    const auto count = std::min(chunk, to.size() - begin);
    {
      const py::gil_scoped_release release;
      delaunay.find_simplex(from.subspan(begin * dimension, count * dimension), to.subspan(begin, count));
    }
    check_signals();
  }
  return found;
}

py::array_t<double> weights(const Delaunay& delaunay, const Coordinates& queries, const Indices& found) {
  const py::ssize_t corners = delaunay.dimension() + 1;
  py::array_t<double> out({found.size(), corners});
  const std::span<double> values{out.mutable_data(), static_cast<std::size_t>(out.size())};
  const auto from = span_of(queries);
  const auto in = span_of(found);
  const py::gil_scoped_release release;
  barycentric_weights(delaunay.points(), delaunay.simplices(), delaunay.dimension(), from, in, values);
  return out;
}

using Pair = std::pair<std::int32_t, std::int32_t>;
static_assert(sizeof(Pair) == 2 * sizeof(std::int32_t));

std::unique_ptr<Delaunay> restore(const Coordinates& points, const Indices& simplices, const Indices& neighbors,
                                  const Indices& duplicates) {
  const auto pairs = reinterpret_cast<const Pair*>(duplicates.data());
  const std::span<const Pair> equal{pairs, static_cast<std::size_t>(duplicates.size()) / 2};
  return std::make_unique<Delaunay>(Delaunay::restore(span_of(points), static_cast<int>(points.shape(1)),
                                                      span_of(simplices), span_of(neighbors), equal));
}

py::array_t<double> transform(const Delaunay& delaunay) {
  const py::ssize_t d = delaunay.dimension();
  py::array_t<double> out({static_cast<py::ssize_t>(delaunay.simplices().size()) / (d + 1), d + 1, d});
  const std::span<double> values{out.mutable_data(), static_cast<std::size_t>(out.size())};
  const py::gil_scoped_release release;
  barycentric_transforms(delaunay.points(), delaunay.simplices(), delaunay.dimension(), values);
  return out;
}

py::tuple neighbors_of_vertices(const Delaunay& delaunay) {
  VertexNeighbors neighbors;
  {
    const py::gil_scoped_release release;
    neighbors = vertex_neighbors(delaunay.simplices(), delaunay.dimension() + 1,
                                 delaunay.points().size() / static_cast<std::size_t>(delaunay.dimension()));
  }
  const auto array = [](const std::vector<std::int32_t>& values) {
    return py::array_t<std::int32_t>(static_cast<py::ssize_t>(values.size()), values.data());
  };
  return py::make_tuple(array(neighbors.starts), array(neighbors.indices));
}

py::array duplicates_view(const py::object& self) {
  const auto pairs = self.cast<const Delaunay&>().duplicates();
  constexpr py::ssize_t size = sizeof(std::int32_t);
  static_assert(sizeof(pairs[0]) == 2 * size);
  return view(py::dtype::of<std::int32_t>(), pairs.data(), {static_cast<py::ssize_t>(pairs.size()), 2},
              {2 * size, size}, self);
}

}  // namespace

void bind_delaunay(py::module_& module) {
  py::class_<Delaunay>(module, "Delaunay")
      .def(py::init(&triangulate_in_memory), py::arg("points").noconvert())
      .def_property_readonly("points",
                             [](const py::object& self) {
                               const auto& delaunay = self.cast<const Delaunay&>();
                               return rows_view(delaunay.points(), delaunay.dimension(), self);
                             })
      .def_property_readonly("simplices",
                             [](const py::object& self) {
                               const auto& delaunay = self.cast<const Delaunay&>();
                               return rows_view(delaunay.simplices(), delaunay.dimension() + 1, self);
                             })
      .def_property_readonly("neighbors",
                             [](const py::object& self) {
                               const auto& delaunay = self.cast<const Delaunay&>();
                               return rows_view(delaunay.neighbors(), delaunay.dimension() + 1, self);
                             })
      .def_property_readonly("duplicates", &duplicates_view)
      .def("find_simplex", &find_simplex, py::arg("queries").noconvert())
      .def_static("restore", &restore)
      .def("weights", &weights, py::arg("queries").noconvert(), py::arg("found").noconvert())
      .def("transform", &transform)
      .def("vertex_neighbors", &neighbors_of_vertices);
}

}  // namespace tessera::python
