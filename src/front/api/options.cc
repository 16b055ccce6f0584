#include "tessera/options.h"

#include <utility>

#include "src/front/api/options_inside.h"

namespace tessera {

TriangulationOptions::TriangulationOptions() : impl_(std::make_unique<Impl>()) {
  impl_->job.threads = 0;
  impl_->job.memory_bytes = 0;
}
TriangulationOptions::TriangulationOptions(const TriangulationOptions& other)
    : impl_(std::make_unique<Impl>(*other.impl_)) {}
TriangulationOptions& TriangulationOptions::operator=(const TriangulationOptions& other) {
  *impl_ = *other.impl_;
  return *this;
}
TriangulationOptions::~TriangulationOptions() = default;

TriangulationOptions& TriangulationOptions::dimension(int dimension) {
  impl_->job.cloud.dimension = dimension;
  return *this;
}
TriangulationOptions& TriangulationOptions::folder(const std::filesystem::path& folder) {
  impl_->folder = folder;
  return *this;
}
TriangulationOptions& TriangulationOptions::overwrite(bool overwrite) {
  impl_->overwrite = overwrite;
  return *this;
}
TriangulationOptions& TriangulationOptions::resume(bool resume) {
  impl_->resume = resume;
  return *this;
}
TriangulationOptions& TriangulationOptions::max_points_per_tile(std::uint64_t points) {
  impl_->job.max_points_per_tile = points;
  return *this;
}
TriangulationOptions& TriangulationOptions::tiles(std::uint32_t tiles) {
  impl_->job.tiles = tiles;
  return *this;
}
TriangulationOptions& TriangulationOptions::partition(const std::string& kind) {
  impl_->partition = kind;
  return *this;
}
TriangulationOptions& TriangulationOptions::threads(std::uint32_t threads) {
  impl_->job.threads = threads;
  return *this;
}
TriangulationOptions& TriangulationOptions::memory_bytes(std::uint64_t bytes) {
  impl_->job.memory_bytes = bytes;
  return *this;
}
TriangulationOptions& TriangulationOptions::neighbors(bool neighbors) {
  impl_->job.neighbors = neighbors;
  return *this;
}
TriangulationOptions& TriangulationOptions::skip_invalid(bool skip_invalid) {
  impl_->job.cloud.skip_invalid = skip_invalid;
  return *this;
}
TriangulationOptions& TriangulationOptions::crop(std::vector<double> box) {
  impl_->crop = std::move(box);
  return *this;
}
TriangulationOptions& TriangulationOptions::periodic(std::vector<double> periods) {
  impl_->job.cloud.periodic = std::move(periods);
  return *this;
}
TriangulationOptions& TriangulationOptions::periodic_files(bool of_files) {
  impl_->job.cloud.periodic_files = of_files;
  return *this;
}
TriangulationOptions& TriangulationOptions::periodic_snap(const std::string& snap) {
  impl_->periodic_snap = snap;
  return *this;
}
TriangulationOptions& TriangulationOptions::crs(const std::string& crs) {
  impl_->crs = crs;
  return *this;
}
TriangulationOptions& TriangulationOptions::store(const std::string& what) {
  impl_->store = what;
  return *this;
}

TriangulationOptions& TriangulationOptions::keep(const std::string& which) {
  impl_->keep = which;
  return *this;
}
TriangulationOptions& TriangulationOptions::heights(bool heights) {
  impl_->job.cloud.heights = heights;
  return *this;
}
TriangulationOptions& TriangulationOptions::classes(std::vector<int> classes) {
  impl_->job.cloud.classes = std::move(classes);
  return *this;
}
TriangulationOptions& TriangulationOptions::scans(std::vector<std::uint32_t> scans) {
  impl_->job.cloud.scans = std::move(scans);
  return *this;
}
TriangulationOptions& TriangulationOptions::returns(const std::string& which) {
  impl_->returns = which;
  return *this;
}
TriangulationOptions& TriangulationOptions::without(std::vector<std::string> flags) {
  impl_->job.cloud.without = std::move(flags);
  return *this;
}
TriangulationOptions& TriangulationOptions::columns(std::vector<std::string> names) {
  impl_->job.cloud.columns = std::move(names);
  return *this;
}
TriangulationOptions& TriangulationOptions::resolution(double distance) {
  impl_->job.cloud.resolution = distance;
  return *this;
}
TriangulationOptions& TriangulationOptions::attributes(std::vector<std::string> names) {
  impl_->job.cloud.attributes = std::move(names);
  return *this;
}
TriangulationOptions& TriangulationOptions::recursive(bool recursive) {
  impl_->job.cloud.recursive = recursive;
  return *this;
}
TriangulationOptions& TriangulationOptions::input_list(const std::filesystem::path& file) {
  impl_->job.cloud.input_list = file.string();
  return *this;
}
TriangulationOptions& TriangulationOptions::endpoint(const std::string& url) {
  impl_->s3.endpoint = url;
  return *this;
}
TriangulationOptions& TriangulationOptions::profile(const std::string& name) {
  impl_->s3.profile = name;
  return *this;
}
TriangulationOptions& TriangulationOptions::anonymous(bool anonymous) {
  impl_->s3.anonymous = anonymous;
  return *this;
}
TriangulationOptions& TriangulationOptions::requester_pays(bool pays) {
  impl_->s3.requester_pays = pays;
  return *this;
}
TriangulationOptions& TriangulationOptions::progress(std::function<void(const JobProgress&)> progress) {
  impl_->progress = std::move(progress);
  return *this;
}
TriangulationOptions& TriangulationOptions::warning(std::function<void(const std::string&)> warning) {
  impl_->warning = std::move(warning);
  return *this;
}
TriangulationOptions& TriangulationOptions::stop(std::stop_token stop) {
  impl_->stop = std::move(stop);
  return *this;
}

ExportRequest::ExportRequest() : impl_(std::make_unique<Impl>()) {}
ExportRequest::ExportRequest(const ExportRequest& other) : impl_(std::make_unique<Impl>(*other.impl_)) {}
ExportRequest& ExportRequest::operator=(const ExportRequest& other) {
  *impl_ = *other.impl_;
  return *this;
}
ExportRequest::~ExportRequest() = default;

ExportRequest& ExportRequest::format(const std::string& format) {
  impl_->options.format = format;
  return *this;
}
ExportRequest& ExportRequest::heights(bool heights) {
  impl_->options.heights = heights;
  return *this;
}
ExportRequest& ExportRequest::local(bool local) {
  impl_->options.local = local;
  return *this;
}
ExportRequest& ExportRequest::index(bool index) {
  impl_->options.spatial_index = index;
  return *this;
}
ExportRequest& ExportRequest::max_edge(double length) {
  impl_->options.max_edge = length;
  return *this;
}
ExportRequest& ExportRequest::max_radius(double length) {
  impl_->options.max_radius = length;
  return *this;
}
ExportRequest& ExportRequest::names(std::vector<std::string> names) {
  impl_->options.names = std::move(names);
  return *this;
}
ExportRequest& ExportRequest::overwrite(bool overwrite) {
  impl_->options.overwrite = overwrite;
  return *this;
}
ExportRequest& ExportRequest::progress(std::function<void(double)> progress) {
  impl_->options.progress = std::move(progress);
  return *this;
}
ExportRequest& ExportRequest::stop(std::stop_token stop) {
  impl_->stop = std::move(stop);
  return *this;
}

VerifyRequest::VerifyRequest() : impl_(std::make_unique<Impl>()) {}
VerifyRequest::VerifyRequest(const VerifyRequest& other) : impl_(std::make_unique<Impl>(*other.impl_)) {}
VerifyRequest& VerifyRequest::operator=(const VerifyRequest& other) {
  *impl_ = *other.impl_;
  return *this;
}
VerifyRequest::~VerifyRequest() = default;

VerifyRequest& VerifyRequest::memory_bytes(std::uint64_t bytes) {
  impl_->options.memory_bytes = bytes;
  return *this;
}
VerifyRequest& VerifyRequest::scratch(const std::filesystem::path& folder) {
  impl_->options.scratch = folder;
  return *this;
}
VerifyRequest& VerifyRequest::against_cgal(bool against_cgal) {
  impl_->options.against_cgal = against_cgal;
  return *this;
}
VerifyRequest& VerifyRequest::stop(std::stop_token stop) {
  impl_->stop = std::move(stop);
  return *this;
}

MeasureRequest::MeasureRequest() : impl_(std::make_unique<Impl>()) {}
MeasureRequest::MeasureRequest(const MeasureRequest& other) : impl_(std::make_unique<Impl>(*other.impl_)) {}
MeasureRequest& MeasureRequest::operator=(const MeasureRequest& other) {
  *impl_ = *other.impl_;
  return *this;
}
MeasureRequest::~MeasureRequest() = default;

MeasureRequest& MeasureRequest::volume(bool volume) {
  impl_->options.volume = volume;
  return *this;
}
MeasureRequest& MeasureRequest::quality(bool quality) {
  impl_->options.quality = quality;
  return *this;
}
MeasureRequest& MeasureRequest::voronoi(bool voronoi) {
  impl_->options.voronoi = voronoi;
  return *this;
}
MeasureRequest& MeasureRequest::density(bool density) {
  impl_->options.density = density;
  return *this;
}
MeasureRequest& MeasureRequest::mass(const std::string& name) {
  impl_->options.mass = name;
  return *this;
}
MeasureRequest& MeasureRequest::memory_bytes(std::uint64_t bytes) {
  impl_->options.memory_bytes = bytes;
  return *this;
}
MeasureRequest& MeasureRequest::threads(unsigned threads) {
  impl_->options.threads = threads;
  return *this;
}
MeasureRequest& MeasureRequest::stop(std::stop_token stop) {
  impl_->stop = std::move(stop);
  return *this;
}

}  // namespace tessera
