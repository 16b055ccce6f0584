// The yardstick: batches inserted into one CGAL triangulation, as its users do it.
#pragma once

#include <memory>
#include <vector>

#include "src/base/point.h"

namespace tessera {

class CgalBatches {
 public:
  CgalBatches(const std::vector<Point>& points, int dimension);
  ~CgalBatches();
  void insert(const std::vector<Point>& points);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tessera
