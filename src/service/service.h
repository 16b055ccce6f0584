// The service: jobs and results of one data folder, for any kind of client. Does not know HTTP. Thread-safe. An
// accepted job is done, over any number of restarts.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "service.pb.h"
#include "src/base/result.h"
#include "src/cluster/cluster_options.h"

namespace tessera {

// What a caller may do. Each role includes the ones before.
enum class Role : std::uint8_t { none, read, submit, admin };

struct Caller {
  std::string name;  // of the token
  Role role = Role::none;
  std::stop_token stop = {};  // stopped when the caller has gone or has waited too long
};

// An answer, or a problem with its HTTP status.
template <class T>
using Reply = boost::outcome_v2::basic_result<T, proto::Problem, boost::outcome_v2::policy::terminate>;

struct ServiceLimits {
  std::uint32_t running = 1;                              // jobs at once
  std::uint32_t queued = 10'000;                          // waiting jobs; more: 429
  std::uint32_t jobs_of_a_caller = 1000;                  // accepted or running
  std::uint32_t ended_of_a_caller = 1000;                 // ended jobs that are kept; the oldest of more are forgotten
  std::uint64_t points = 0, disk_bytes = 0;               // of one job; 0: what the machine has
  std::uint64_t reserve_bytes = std::uint64_t{64} << 20;  // of the disk, that jobs and uploads leave free
  std::uint64_t upload_bytes = 0;                         // of all uploads together; 0: what the disk has
  // A job during which the process died is begun again, alone, so that other jobs are not blamed. After this many
  // successive deaths the job has failed, and only resume() begins it again.
  std::uint32_t deaths = 3;
};

struct ServiceOptions {
  std::filesystem::path data;                // made when missing
  std::vector<std::filesystem::path> roots;  // folders of inputs
  std::uint64_t memory_bytes = 0;            // for all running jobs together
  std::uint32_t threads = 1;
  bool uploads = false;
  std::uint64_t retention_s = 0;  // ended jobs are forgotten after it; 0: never. Results are always kept.
  ServiceLimits limits;
  // How long another process keeps the data folder's lock without a sign of life. The same for all daemons of the
  // folder.
  std::chrono::milliseconds data_lease{60'000};
  // Called once when the data folder is lost: another process holds it, or it is gone. From then on the service does
  // nothing, and its answers may be wrong. A daemon ends here.
  std::function<void(const Error&)> lost = {};
  // Called with a sentence while another process holds the data folder. Returns true to try again.
  std::function<bool(const Error&)> locked = {};
  std::optional<ClusterOptions> cluster = {};         // the cluster that works on jobs; nothing: this process alone
  std::function<void(const std::string&)> log = {};   // gets warnings and errors of the service itself, line by line
  std::function<void(const std::string&)> note = {};  // gets lines about normal events
};

// A file to be sent. It is open for reading, so that no other file can take its place.
struct ServedFile {
  int descriptor = -1;  // the receiver closes it
  std::uint64_t bytes = 0;
  std::string type;  // media type
  std::string etag;  // strong, quoted, from the checksum in the manifest; empty for a file that still grows
};

// A question to a result, with options as text. The service reads options as the commands do.
struct Question {
  enum class About : std::uint8_t {
    locate,
    star,
    cells,
    interpolate,
    dem,
    hull,
    section,
    solids,
    contours,
    profile,
    features,  // of the collection of kind `kind`: bbox, limit, after; item: only that feature
    map_tile   // level, row, column, style
  };
  About about = About::locate;
  std::string triangulation;
  std::string vertex = {};                          // star: the source index of the vertex
  std::map<std::string, std::string> options = {};  // point, cell, tile, bbox, f, limit, value, method, weights, ...
  std::optional<std::string> body = {};  // locate, interpolate: many points; cells: a polygon; profile: a line
  std::string type = {};                 // media type of the body
  // Answer with a message of proto/query.proto. REQUIRES: has_message(about), and no option f.
  bool as_message = false;
  std::stop_token stop = {};  // the caller has gone
};

// True if there is a message for the answers. Other answers are files, pictures and GeoJSON.
constexpr bool has_message(Question::About about) {
  using About = Question::About;
  return about == About::locate || about == About::star || about == About::interpolate || about == About::profile;
}
inline constexpr const char* protobuf_type = "application/x-protobuf";

struct QuestionAnswer {
  std::string text = {};                // with the type below; or
  std::optional<ServedFile> file = {};  // a file, which has its own type
  std::string type = {};
  bool final = true;  // the answer provably holds for the triangulation of all points
  // For features, whose text is a JSON object without its last brace: where the next page begins, if there is one.
  std::optional<std::uint64_t> next = {};
};

// A collection of features that a result offers for maps.
struct FeatureCollection {
  std::string id;             // NAME.kind
  std::string triangulation;  // NAME
  std::string kind;           // tiles, hull, contours
  std::string title = {}, description = {};
  std::array<double, 4> extent{};  // west, south, east, north
  std::string storage_crs = {};    // a URI: features are also offered in the result's system; or empty
};
// The coordinate system of features, unless the client asks for another.
inline constexpr const char* crs84_uri = "http://www.opengis.net/def/crs/OGC/1.3/CRS84";

struct JobQuery {
  std::vector<std::string> states = {}, processes = {};  // empty: all
  std::string after = {};                                // the last job of the page before
  std::uint32_t limit = 100;
};

// What front ends ask of the service, and all that they know of it. Thread-safe.
class Backend {
 public:
  virtual ~Backend() = default;

  // Submits a job. A repeated call with the same key and inputs returns the same job; with other inputs it is 422.
  // `fresh` is true for a new job.
  struct Submitted {
    proto::StatusInfo status;
    bool fresh = true;
  };
  virtual Reply<Submitted> submit(const proto::Inputs& inputs, const Caller& caller,
                                  std::string_view idempotency_key = {}) = 0;
  // Estimates the cost of triangulate, region, dem and contours.
  virtual Reply<proto::Estimate> estimate(const proto::Inputs& inputs, const Caller& caller) = 0;
  // Answers short info jobs at once, with what `tessera info --json` prints. Statistics of many points and compressed
  // files take too long: 400, submit a job instead.
  virtual Reply<std::string> info(const proto::InfoInputs& inputs, const Caller& caller) = 0;

  virtual Reply<proto::JobList> jobs(const JobQuery& query) = 0;
  virtual Reply<proto::StatusInfo> job(std::string_view id) = 0;
  // Dismisses a job. A running or waiting job is dismissed when this returns, and can be resumed; an ended job is
  // forgotten (410 from then on). Results stay. Threads and memory of a running job are free soon, mostly within tenths
  // of a second: work on tiles is broken off, and the images of tiles in memory, up to 256 MiB, are written.
  virtual Reply<proto::StatusInfo> dismiss(std::string_view id, const Caller& caller) = 0;
  virtual Reply<proto::StatusInfo> resume(std::string_view id, const Caller& caller) = 0;
  virtual Reply<ServedFile> log(std::string_view id) = 0;
  virtual Reply<ServedFile> report(std::string_view id) = 0;
  // The progress of the tiles of a triangulation that runs or has succeeded; with the planes between tiles when asked
  // for.
  virtual Reply<proto::JobTiles> tiles(std::string_view id, bool with_layout) = 0;
  // What a verify, export or info job found, as JSON; 404 result-not-ready before it ends.
  virtual Reply<std::string> outcome(std::string_view id) = 0;

  // Delivers events after `last` (0: from now on), of one job or of all (""), in order, as they come. Any thread may
  // call `on_event`, which must not block. Events that are no longer kept are replaced by a status of each job. Ends
  // when the handle is destroyed.
  class Subscription {
   public:
    virtual ~Subscription() = default;
  };
  using OnEvent = std::function<void(const std::shared_ptr<const proto::Event>&)>;
  virtual Reply<std::unique_ptr<Subscription>> subscribe(std::string_view id, std::uint64_t last, OnEvent on_event) = 0;

  virtual Reply<proto::TriangulationList> triangulations(std::uint32_t limit, std::string_view after) = 0;
  virtual Reply<proto::TriangulationInfo> triangulation(std::string_view name) = 0;
  virtual Reply<ServedFile> file(std::string_view name, std::string_view path) = 0;
  // 409 while a job uses the triangulation.
  virtual Reply<void> remove_triangulation(std::string_view name, const Caller& caller) = 0;
  // The exports of a triangulation by name: files and folders, in pages as above.
  virtual Reply<proto::ExportList> exports(std::string_view name, std::uint32_t limit, std::string_view after) = 0;
  // Removes an export. 409 while a job writes it.
  virtual Reply<void> remove_export(std::string_view name, std::string_view file, const Caller& caller) = 0;

  // The identity of this result, which differs from that of any other result that had or will have its name. For one
  // identity, this program always gives the same answers.
  virtual Reply<std::string> identity(std::string_view name) = 0;
  // Answers a question. May read from disk. 404; 400 for options that make no sense; 422 for invalid points or
  // polygons, and for too large an answer; 410 when the caller or the result has gone meanwhile; 500 for a damaged
  // tile.
  virtual Reply<QuestionAnswer> ask(const Question& question) = 0;

  // The collections for maps of all results with a known place on the earth, by name.
  virtual Reply<std::vector<FeatureCollection>> collections() = 0;
  // Also 404 for a possible name without a collection: the result has no coordinate system or no contour lines.
  virtual Reply<FeatureCollection> collection(std::string_view id) = 0;
  // West, south, east and north of the raster of a result's heights; 404 when it has none.
  virtual Reply<std::array<double, 4>> map_extent(std::string_view name) = 0;

  // Receives the bytes of an upload from `offset` on as they come. The file gets its name in finish().
  class Upload {
   public:
    virtual ~Upload() = default;
    virtual Reply<void> write(std::string_view bytes) = 0;
    virtual Reply<void> finish() = 0;
  };
  virtual Reply<std::unique_ptr<Upload>> upload(std::string_view folder, std::string_view file, std::uint64_t offset,
                                                const Caller& caller) = 0;
  virtual Reply<std::uint64_t> uploaded(std::string_view folder, std::string_view file) = 0;
  // Also removes a partial upload. 409 while the file is being sent.
  virtual Reply<void> remove_upload(std::string_view folder, std::string_view file, const Caller& caller) = 0;

  // The entries of a folder that jobs may read, by name, in pages as above: point files with what their headers say,
  // and folders. "" lists all roots and the uploads. 400 for what is no folder below the roots.
  virtual Reply<proto::InputList> inputs(std::string_view folder, std::uint32_t limit, std::string_view after,
                                         const Caller& caller) = 0;

  // The nodes that work on jobs, in the order in which they joined.
  virtual Reply<proto::NodeList> nodes() = 0;
  // Takes all work from a node, given by name or id, and ends its process. Returns the node; 409 for the only node.
  virtual Reply<proto::NodeInfo> drain(std::string_view node, const Caller& caller) = 0;

  // Figures for /metrics and /readyz.
  struct Figures {
    std::uint64_t accepted = 0, running = 0;                  // now
    std::uint64_t successful = 0, failed = 0, dismissed = 0;  // since the start
    std::uint64_t points = 0;                                 // triangulated since the start
    std::uint64_t updates_waiting = 0;                        // in the inboxes of tiles or on the way there, now
    std::uint64_t memory_budget_bytes = 0, memory_used_bytes = 0, disk_free_bytes = 0;
    std::vector<std::pair<std::string, double>> phase_seconds;
    std::uint64_t subscribers = 0;
    std::uint64_t open_results = 0;                                 // kept open for questions
    std::vector<std::pair<std::string, std::uint64_t>> nodes = {};  // by state
    std::uint64_t nodes_lost = 0;                                   // since the start
    std::uint64_t bytes_between = 0, credit_waits = 0;  // sent between nodes, and waits for credit, since the start
    double certificate_end_s = 0;  // when this process's certificate for the cluster expires, since 1970; 0: no cluster
  };
  virtual Figures figures() const = 0;
  // Nothing when jobs can be accepted; else the reason: a full or read-only folder, or a scheduler that does not
  // respond.
  virtual std::optional<std::string> unready() const = 0;
  // Set once the data folder belongs to another daemon or is gone: the reason why answers must not be trusted. Fast.
  virtual std::optional<std::string> lost() const = 0;
};

class Service final : public Backend {
 public:
  // Takes the data folder (one daemon a folder), reads its jobs, and continues unfinished ones. Errors: usage for wrong
  // options; io for a folder that cannot be used or that another daemon holds; corrupt for a folder of a newer version.
  static Result<std::unique_ptr<Service>> open(ServiceOptions options);
  // Interrupts running jobs, which can be resumed.
  ~Service() override;

  Reply<Submitted> submit(const proto::Inputs& inputs, const Caller& caller,
                          std::string_view idempotency_key = {}) override;
  Reply<proto::Estimate> estimate(const proto::Inputs& inputs, const Caller& caller) override;
  Reply<std::string> info(const proto::InfoInputs& inputs, const Caller& caller) override;
  Reply<proto::JobList> jobs(const JobQuery& query) override;
  Reply<proto::StatusInfo> job(std::string_view id) override;
  Reply<proto::StatusInfo> dismiss(std::string_view id, const Caller& caller) override;
  Reply<proto::StatusInfo> resume(std::string_view id, const Caller& caller) override;
  Reply<ServedFile> log(std::string_view id) override;
  Reply<ServedFile> report(std::string_view id) override;
  Reply<proto::JobTiles> tiles(std::string_view id, bool with_layout) override;
  Reply<std::string> outcome(std::string_view id) override;
  Reply<std::unique_ptr<Subscription>> subscribe(std::string_view id, std::uint64_t last, OnEvent on_event) override;
  Reply<proto::TriangulationList> triangulations(std::uint32_t limit, std::string_view after) override;
  Reply<proto::TriangulationInfo> triangulation(std::string_view name) override;
  Reply<ServedFile> file(std::string_view name, std::string_view path) override;
  Reply<void> remove_triangulation(std::string_view name, const Caller& caller) override;
  Reply<proto::ExportList> exports(std::string_view name, std::uint32_t limit, std::string_view after) override;
  Reply<void> remove_export(std::string_view name, std::string_view file, const Caller& caller) override;
  Reply<std::string> identity(std::string_view name) override;
  Reply<QuestionAnswer> ask(const Question& question) override;
  Reply<std::vector<FeatureCollection>> collections() override;
  Reply<FeatureCollection> collection(std::string_view id) override;
  Reply<std::array<double, 4>> map_extent(std::string_view name) override;
  Reply<std::unique_ptr<Upload>> upload(std::string_view folder, std::string_view file, std::uint64_t offset,
                                        const Caller& caller) override;
  Reply<std::uint64_t> uploaded(std::string_view folder, std::string_view file) override;
  Reply<void> remove_upload(std::string_view folder, std::string_view file, const Caller& caller) override;
  Reply<proto::InputList> inputs(std::string_view folder, std::uint32_t limit, std::string_view after,
                                 const Caller& caller) override;
  Reply<proto::NodeList> nodes() override;
  Reply<proto::NodeInfo> drain(std::string_view node, const Caller& caller) override;
  Figures figures() const override;
  std::optional<std::string> unready() const override;
  std::optional<std::string> lost() const override;

 private:
  struct Impl;
  explicit Service(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace tessera
