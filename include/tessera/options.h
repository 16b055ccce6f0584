// The options of the library's functions. Each class has one function for each option, which returns *this. The classes
// show programs nothing else. So later versions can add options, and programs that are already built still run.
//
//   tessera::triangulate({"block/*.laz"}, tessera::TriangulationOptions().dimension(2).classes({2, 9}));
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "tessera/visibility.h"

namespace tessera {

// The progress of a job. Only the library makes objects of this type, and later versions may append members.
struct JobProgress {
  std::string phase;  // "planning", "routing", "triangulating", "splaying", "collecting", "finishing", "done"
  std::uint64_t points_total = 0;  // 0 while unknown
  std::uint64_t points_routed = 0, points_triangulated = 0;
  std::uint32_t tiles_total = 0, tiles_triangulated = 0, tiles_stored = 0;
  double seconds = 0;  // since the job began
};

// The options of `tessera triangulate`. The function that gets the options reports values that make no sense, with a
// Failure (usage).
class TESSERA_PUBLIC TriangulationOptions {
 public:
  TriangulationOptions();
  TriangulationOptions(const TriangulationOptions&);
  TriangulationOptions& operator=(const TriangulationOptions&);
  ~TriangulationOptions();

  // 2 or 3; 3 by default. For files also 0: 2 if no file has z, else 3.
  TriangulationOptions& dimension(int dimension);

  // The result folder, which stays. Empty, the default: a folder in the system's temporary folder, which is removed
  // with the last copy of the Triangulation.
  TriangulationOptions& folder(const std::filesystem::path& folder);
  // Replaces an earlier result in the folder.
  TriangulationOptions& overwrite(bool overwrite);
  // Continues the unfinished run in the folder, or starts one. An unfinished run must have the same points and options.
  // If this run is stopped, it stays in the folder and can be continued, too. REQUIRES: folder(). For files only.
  TriangulationOptions& resume(bool resume);

  // How many points a tile has at most, or how many tiles there are. Only one of the two may be given. 0, the default:
  // chosen from memory and threads.
  TriangulationOptions& max_points_per_tile(std::uint64_t points);
  TriangulationOptions& tiles(std::uint32_t tiles);
  // How space is cut into tiles: "kdtree", the default, "grid", "octree" or "random".
  TriangulationOptions& partition(const std::string& kind);
  // 0, the default: all processors that this process may use.
  TriangulationOptions& threads(std::uint32_t threads);
  // 0, the default: 70 % of the free memory.
  TriangulationOptions& memory_bytes(std::uint64_t bytes);
  // Stores the neighbours of cells (the default).
  TriangulationOptions& neighbors(bool neighbors);

  // What is stored: "cells"; "points", which takes a tenth of the bytes, and cells are made again when they are read;
  // or "auto", the default: points for clouds of more than 50 million points, else cells.
  TriangulationOptions& store(const std::string& what);

  // Leaves out points with NaN or infinite coordinates. By default such a point is a Failure (bad_input).
  TriangulationOptions& skip_invalid(bool skip_invalid);
  // Leaves out points outside the closed box: xmin, ymin, xmax, ymax (any z), or in 3D also xmin, ymin, zmin, xmax,
  // ymax, zmax. Empty, the default: no crop.
  TriangulationOptions& crop(std::vector<double> box);
  // The cloud is periodic: one period for all axes, or one for each, 0 for an axis without a period. Points are moved
  // into the box that begins at 0. Empty, the default: no period.
  TriangulationOptions& periodic(std::vector<double> periods);
  // The periods are the sides of the box that the files (snapshots of simulations) state.
  TriangulationOptions& periodic_files(bool of_files);
  // "yes", the default: coordinates and periods with too many binary digits for exact images are rounded, by 2^-52 of
  // the period at most, with a warning. "no": they are refused.
  TriangulationOptions& periodic_snap(const std::string& snap);
  // The coordinate system of all points, in place of what the files say: "EPSG:n", WKT, or the name of a file with one
  // of them. Empty, the default: what the files say.
  TriangulationOptions& crs(const std::string& crs);
  // 2D: which of several points with equal x and y becomes the vertex: the "first" (the default), "last", "lowest" or
  // "highest".
  TriangulationOptions& keep(const std::string& which);

  // The following options are for files; heights() and attributes() also for Records.

  // 2D: keeps z as the attribute "z" (the default).
  TriangulationOptions& heights(bool heights);
  // Takes only points of these LAS classes, 0 to 255. Empty, the default: all.
  TriangulationOptions& classes(std::vector<int> classes);
  // E57 and PTX files: takes only points of these scans, numbered from 0 in each file. Empty, the default: all.
  TriangulationOptions& scans(std::vector<std::uint32_t> scans);
  // Takes only the "first", "last" or "single" return of each laser pulse; "all", the default, takes all.
  TriangulationOptions& returns(const std::string& which);
  // Leaves out points that have one of these LAS flags: "withheld", "synthetic", "overlap", "key_point".
  TriangulationOptions& without(std::vector<std::string> flags);
  // Text and NumPy files: the names of the columns in order, in place of those in the files: "x", "y", "z", the name of
  // an attribute, or "_" for a column to leave out. Empty, the default: what the files say.
  TriangulationOptions& columns(std::vector<std::string> names);
  // COPC files: reads the octree levels down to the first level whose points are at most so far apart, and no finer
  // ones. 0, the default: all levels.
  TriangulationOptions& resolution(double distance);
  // The attributes of the points that the result keeps; {"all"} keeps all.
  TriangulationOptions& attributes(std::vector<std::string> names);
  // Takes the files in subfolders of input folders, too.
  TriangulationOptions& recursive(bool recursive);
  // A text file that names more inputs, one a line. Relative names are relative to the folder of this file.
  TriangulationOptions& input_list(const std::filesystem::path& file);

  // For inputs s3://bucket/...: the server, "https://host[:port]", in place of Amazon's; the profile in ~/.aws;
  // requests that are not signed, for open data; and the consent to pay for the transfer. By default as the environment
  // says.
  TriangulationOptions& endpoint(const std::string& url);
  TriangulationOptions& profile(const std::string& name);
  TriangulationOptions& anonymous(bool anonymous);
  TriangulationOptions& requester_pays(bool pays);

  // `progress` is called some ten times a second, and once at the end, in the thread that called triangulate(). If
  // `progress` throws, the job ends and triangulate() throws the same exception. An unfinished job leaves nothing in
  // the folder, except with resume().
  TriangulationOptions& progress(std::function<void(const JobProgress&)> progress);
  // `warning` is called in the same thread, at the end, once for each sentence about something doubtful in the input.
  TriangulationOptions& warning(std::function<void(const std::string&)> warning);
  TriangulationOptions& stop(std::stop_token stop);

 private:
  friend struct OptionsInside;
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// The options of Triangulation::export_to(), which writes a result for other programs.
class TESSERA_PUBLIC ExportRequest {
 public:
  ExportRequest();
  ExportRequest(const ExportRequest&);
  ExportRequest& operator=(const ExportRequest&);
  ~ExportRequest();

  // "ply", "vtu", "gpkg", ... (docs/formats.md). Empty, the default: the format of the target's ending.
  ExportRequest& format(const std::string& format);
  // 2D: the attribute "z", if the result has it, becomes the third coordinate (the default).
  ExportRequest& heights(bool heights);
  // GeoPackage: writes a spatial index (the default). Writing is four times as fast without an index, but maps are
  // slow.
  ExportRequest& index(bool index);
  // Leaves out cells with an edge longer than `length`, and vertices that then have no cell. `length` is in units of
  // the coordinates (2D: in the plane), finite and above 0.
  ExportRequest& max_edge(double length);
  // Leaves out cells with a circumradius larger than `length`, likewise. Circumradii are compared exactly.
  ExportRequest& max_radius(double length);
  // ply, obj, off, stl: writes coordinates relative to the lower corner of the box, rounded down to whole numbers, for
  // programs that keep 32-bit floats.
  ExportRequest& local(bool local);
  // h5, fits, table, ndnet: which attributes and computed columns of vertices are written. Empty, the default: all, for
  // ndnet the column density.
  ExportRequest& names(std::vector<std::string> names);
  // Replaces existing files of the same names.
  ExportRequest& overwrite(bool overwrite);
  // `progress` is called now and then with the fraction that is done, 0 to 1, in the thread that called export_to().
  // If `progress` throws, the export ends and export_to() throws the same exception.
  ExportRequest& progress(std::function<void(double)> progress);
  ExportRequest& stop(std::stop_token stop);

 private:
  friend struct OptionsInside;
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// The options of Triangulation::verify().
class TESSERA_PUBLIC VerifyRequest {
 public:
  VerifyRequest();
  VerifyRequest(const VerifyRequest&);
  VerifyRequest& operator=(const VerifyRequest&);
  ~VerifyRequest();

  // The memory for facets; more facets are sorted on disk. 0, the default: 70 % of the free memory.
  VerifyRequest& memory_bytes(std::uint64_t bytes);
  // The folder in which facets are sorted. Empty, the default: the system's temporary folder.
  VerifyRequest& scratch(const std::filesystem::path& folder);
  // Also triangulates all points with CGAL in memory, and compares the two sets of cells.
  VerifyRequest& against_cgal(bool against_cgal);
  VerifyRequest& stop(std::stop_token stop);

 private:
  friend struct OptionsInside;
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// The options of Triangulation::measure(): what is measured.
class TESSERA_PUBLIC MeasureRequest {
 public:
  MeasureRequest();
  MeasureRequest(const MeasureRequest&);
  MeasureRequest& operator=(const MeasureRequest&);
  ~MeasureRequest();

  // The volume of each cell, and for each vertex the sum of the volumes of its cells; in 2D areas in the plane.
  MeasureRequest& volume(bool volume);
  // The shape of each cell, as columns radius_ratio (d times the radius of the inscribed sphere, divided by that of the
  // circumsphere: 1 for a regular cell, near 0 for a flat one), least_angle and largest_angle (degrees; in 3D dihedral
  // angles), and circumradius.
  MeasureRequest& quality(bool quality);
  // The Voronoi cell of each vertex, as columns voronoi_volume and voronoi_surface (in 2D voronoi_area and
  // voronoi_boundary; infinite on the hull), voronoi_neighbours, and the centroid voronoi_x, voronoi_y, voronoi_z (NaN
  // on the hull). Failure: also usage for a region.
  MeasureRequest& voronoi(bool voronoi);
  // The density of each vertex, as column density: (dimension + 1) times its mass, divided by the volume of the cells
  // around it. Each point has the mass 1, duplicates included. Failure: also usage for a region.
  MeasureRequest& density(bool density);
  // The attribute of the vertices that has their masses, for density(); the column is then density_NAME.
  MeasureRequest& mass(const std::string& name);
  // The memory for tiles; 0, the default: 70 % of the free memory.
  MeasureRequest& memory_bytes(std::uint64_t bytes);
  // 0, the default: all processors.
  MeasureRequest& threads(unsigned threads);
  MeasureRequest& stop(std::stop_token stop);

 private:
  friend struct OptionsInside;
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tessera
