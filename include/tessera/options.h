// What can be asked of the library beside the points. Classes with a function for each option, and nothing else that a
// program could see: a new option is a new function, and programs built before it run as they did.
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

// How far a job is. Only the library makes them: later versions may append members.
struct JobProgress {
  std::string phase;  // "planning", "routing", "triangulating", "splaying", "collecting", "finishing", "done"
  std::uint64_t points_total = 0;  // 0 while unknown
  std::uint64_t points_routed = 0, points_triangulated = 0;
  std::uint32_t tiles_total = 0, tiles_triangulated = 0, tiles_stored = 0;
  double seconds = 0;  // since the job began
};

// The options of `tessera triangulate`. What makes no sense is told by the call that is given them.
class TESSERA_PUBLIC TriangulationOptions {
 public:
  TriangulationOptions();
  TriangulationOptions(const TriangulationOptions&);
  TriangulationOptions& operator=(const TriangulationOptions&);
  ~TriangulationOptions();

  // 2 or 3, the default; 0, for files only: 2 when no file holds z.
  TriangulationOptions& dimension(int dimension);

  // The result folder, which stays. Empty: a temporary folder under std::filesystem::temp_directory_path(), removed
  // with the last copy of the Triangulation.
  TriangulationOptions& folder(const std::filesystem::path& folder);
  // Replace an earlier result in the folder.
  TriangulationOptions& overwrite(bool overwrite);
  // Go on with the unfinished run in the folder, of the same points and options, or start one; and leave what there is
  // of this run in the folder when it is stopped. REQUIRES: folder().
  TriangulationOptions& resume(bool resume);

  // 0: chosen from memory and threads. One of these two.
  TriangulationOptions& max_points_per_tile(std::uint64_t points);
  TriangulationOptions& tiles(std::uint32_t tiles);
  // "kdtree", the default, "grid", "octree" or "random".
  TriangulationOptions& partition(const std::string& kind);
  // 0: all that this process may use.
  TriangulationOptions& threads(std::uint32_t threads);
  // 0: 70 % of what is free.
  TriangulationOptions& memory_bytes(std::uint64_t bytes);
  // Keep the neighbours of cells (the default).
  TriangulationOptions& neighbors(bool neighbors);

  // What is stored: "cells"; "points", a tenth of the bytes, from which cells are made again when they are asked for;
  // or "auto", the default: points for clouds of more than 50 million.
  TriangulationOptions& store(const std::string& what);

  // Leave points with NaN or infinite coordinates out, do not fail.
  TriangulationOptions& skip_invalid(bool skip_invalid);
  // xmin, ymin, xmax, ymax, or in 3D xmin, ymin, zmin, xmax, ymax, zmax: points outside are left out, those on the
  // boundary are not. Empty, the default: no crop.
  TriangulationOptions& crop(std::vector<double> box);
  // The coordinate system of all points, whatever the files say: "EPSG:n", WKT, or a file with one of them. Empty: what
  // the files say.
  TriangulationOptions& crs(const std::string& crs);
  // 2D: of points with equal x and y the "first", which is the default, "last", "lowest" or "highest" is the vertex.
  TriangulationOptions& keep(const std::string& which);

  // The following are for files alone.
  // In 2D, keep z as the attribute "z" (the default).
  TriangulationOptions& heights(bool heights);
  // Points of these LAS classes only; empty: all.
  TriangulationOptions& classes(std::vector<int> classes);
  // Of each pulse the "first", "last" or "single" return only; "all", the default.
  TriangulationOptions& returns(const std::string& which);
  // No points with one of these flags: "withheld", "synthetic", "overlap", "key_point".
  TriangulationOptions& without(std::vector<std::string> flags);
  // Text and NumPy: what the columns are, in their order, whatever the files say: "x", "y", "z", the name of an
  // attribute, or "_" to leave one out. Empty: what the files say.
  TriangulationOptions& columns(std::vector<std::string> names);
  // COPC: the octree levels down to the first whose points are at most so far apart, and no finer; 0: all.
  TriangulationOptions& resolution(double distance);
  // Of the points, to be kept; "all" for all there are.
  TriangulationOptions& attributes(std::vector<std::string> names);
  // Take the files in subfolders of folders, too.
  TriangulationOptions& recursive(bool recursive);
  // A text file that names more inputs, one a line; relative ones begin at its folder.
  TriangulationOptions& input_list(const std::filesystem::path& file);

  // Called some ten times a second, and once at the end, in the thread that called triangulate(). An exception ends the
  // job, and comes out of triangulate(). Of an unfinished job nothing stays in the folder, unless it is to be resumed.
  TriangulationOptions& progress(std::function<void(const JobProgress&)> progress);
  // Called in that thread, at the end, with each sentence about what is doubtful in the input.
  TriangulationOptions& warning(std::function<void(const std::string&)> warning);
  TriangulationOptions& stop(std::stop_token stop);

 private:
  friend struct OptionsInside;
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// How a result is written for other programs.
class TESSERA_PUBLIC ExportRequest {
 public:
  ExportRequest();
  ExportRequest(const ExportRequest&);
  ExportRequest& operator=(const ExportRequest&);
  ~ExportRequest();

  // "ply", "vtu", "gpkg", ... (docs/formats.md); empty: as the ending of the target says.
  ExportRequest& format(const std::string& format);
  // 2D: the attribute "z", if there is one, becomes the third coordinate (the default).
  ExportRequest& heights(bool heights);
  // GeoPackage: write a spatial index (the default). Without it writing is four times as fast, but maps are slow.
  ExportRequest& index(bool index);
  // Leave out cells with an edge longer than this, in units of the coordinates (2D: in the plane), and vertices that no
  // cell has then. Finite and above 0.
  ExportRequest& max_edge(double length);
  // ply, obj, off: coordinates count from the whole-numbered corner of the box, for programs that keep floats of 32
  // bits.
  ExportRequest& local(bool local);
  // Replace files of the same names.
  ExportRequest& overwrite(bool overwrite);
  // Told now and then which part is done, 0 to 1, in the thread that called. An exception ends the work, and comes out.
  ExportRequest& progress(std::function<void(double)> progress);
  ExportRequest& stop(std::stop_token stop);

 private:
  friend struct OptionsInside;
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// How a result is proved.
class TESSERA_PUBLIC VerifyRequest {
 public:
  VerifyRequest();
  VerifyRequest(const VerifyRequest&);
  VerifyRequest& operator=(const VerifyRequest&);
  ~VerifyRequest();

  // For facets before they are sorted on disk; 0: 70 % of what is free.
  VerifyRequest& memory_bytes(std::uint64_t bytes);
  // Where to sort them; empty: the system's temporary folder.
  VerifyRequest& scratch(const std::filesystem::path& folder);
  // Also build the whole triangulation with CGAL in memory, and compare the sets of cells.
  VerifyRequest& against_cgal(bool against_cgal);
  VerifyRequest& stop(std::stop_token stop);

 private:
  friend struct OptionsInside;
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// What is measured of a result.
class TESSERA_PUBLIC MeasureRequest {
 public:
  MeasureRequest();
  MeasureRequest(const MeasureRequest&);
  MeasureRequest& operator=(const MeasureRequest&);
  ~MeasureRequest();

  // The volume of each cell, and of each vertex that of the cells around it; in 2D areas in the plane.
  MeasureRequest& volume(bool volume);
  // For tiles; 0: 70 % of what is free.
  MeasureRequest& memory_bytes(std::uint64_t bytes);
  // 0: all processors.
  MeasureRequest& threads(unsigned threads);
  MeasureRequest& stop(std::stop_token stop);

 private:
  friend struct OptionsInside;
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tessera
