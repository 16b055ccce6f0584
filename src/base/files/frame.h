// What is put on scratch and taken back: files of frames, each with a checksum, so that damage is never believed.
//
//   file   = frame*
//   frame  = magic    u32  "TsFb"
//            kind     u32  what the payload is
//            length   u64  of the payload
//            run      u64  which run it belongs to
//            item     u64  and what of that: a tile, a node, ...
//            checksum u64  XXH3-64 of the payload, seeded with the XXH3-64 of the 32 bytes before
//            payload
//
// Little endian. Any flipped bit, a truncation, rubbish at the end, a frame of another kind, or one that belongs to
// something else, as when files were exchanged: error corrupt, naming the file and the place. So is a frame of older
// software ("TsFr"), which did not say what it belongs to. What cannot be told: that whole frames are missing at the
// end of a file. Who appends counts.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <vector>

#include "src/base/big_vector.h"
#include "src/base/files/names.h"
#include "src/base/result.h"

namespace tessera {

// The bytes a frame takes besides its payload.
inline constexpr std::uint64_t frame_header_bytes = 40;

// What a frame belongs to.
struct FrameOwner {
  std::uint64_t run = 0;   // RoutedCloud::seal; 0 for what is there before the run is routed
  std::uint64_t item = 0;  // of the run: the number of a tile, a node, an attempt
};

// Appends one frame; makes the file, not its folder. Opens and closes the file once. Error io, and then the end of the
// file may be damaged.
Status append_frame(const std::filesystem::path& path, ScratchKind kind, const FrameOwner& owner,
                    std::span<const std::byte> payload);
// Makes a file of one frame: under `path` there is the old file or the new one, whenever the process ends. Not synced:
// a power cut may damage it, which reading tells. Error io.
Status write_frame(const std::filesystem::path& path, ScratchKind kind, const FrameOwner& owner,
                   std::span<const std::byte> payload);

// The payload of a file of one frame. Error io when there is none, corrupt.
Result<BigVector<std::byte>> read_frame(const std::filesystem::path& path, ScratchKind kind, const FrameOwner& owner);
// Calls `visit` with the payloads of a file's frames in order, until it returns an error. One payload is in memory at a
// time. Error io when there is no file, corrupt.
using VisitFrame = std::function<Status(BigVector<std::byte> payload)>;
Status for_each_frame(const std::filesystem::path& path, ScratchKind kind, const FrameOwner& owner,
                      const VisitFrame& visit);

// Files of many frames, of which each is read by itself.
//
// Where they begin: an index, made without reading what is in them. What comes after damage is not in it; an owner may
// be damaged. Error io.
struct FramePlace {
  FrameOwner owner;
  std::uint64_t at = 0;
};
Result<std::vector<FramePlace>> places_of_frames(const std::filesystem::path& path, ScratchKind kind);
// The payload of the frame that begins at byte `at`. Error io, corrupt.
Result<BigVector<std::byte>> read_frame_at(const std::filesystem::path& path, ScratchKind kind, const FrameOwner& owner,
                                           std::uint64_t at);

}  // namespace tessera
