// A program is what the tiles of a stage compute: one object a tile. The exchange (src/exchange/tile_life.h) carries
// messages, puts tiles to sleep, moves them, and begins them again after a loss. Only the program knows what a message
// means.
//
// At most one thread at a time calls a program, in the order that TileLife keeps. The program itself reads and writes
// what it keeps on scratch beside the image.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "src/base/big_vector.h"
#include "src/base/figures.h"
#include "src/base/ids.h"
#include "src/base/result.h"
#include "src/exchange/tile_storage.h"

namespace tessera {

using Message = BigVector<std::byte>;
using Image = BigVector<std::byte>;

// From which life of the tile an image comes.
enum class ImageOf : std::uint8_t {
  sleeper,  // from this object, which fell asleep
  earlier,  // from another life, in an earlier process or on another node: what it told may be lost, and is told again
  settled   // from another life, when all was quiet: finish() follows
};

// What is to be known of a tile that has come to the end of its stage, as bytes that only the stage's owner
// understands.
using Receipt = BigVector<std::byte>;
inline constexpr std::size_t receipt_bytes_max = 1'000;
struct TileReceipt {
  TileId tile;
  Receipt receipt;
};

// What a tile leaves at the end of its stage.
class Finished {
 public:
  virtual ~Finished() = default;
  virtual std::uint64_t bytes() const = 0;  // in memory
  // Keeps the tile where the code after the stage finds it, and then calls `done` with the receipt, from any thread.
  // May return before that. `done` does not throw. `done` is called exactly once, also after an error, unless store()
  // itself throws.
  using Stored = std::function<void(Result<Receipt>)>;
  virtual void store(Stored done) = 0;
};

// The program of one tile in one stage. Calls that change it may throw Stopped, when the job is stopped, and Unsound,
// when what was read from scratch cannot be worked with. After that the program may only be destroyed, or begin again.
class TileProgram {
 public:
  virtual ~TileProgram() = default;

  // Begins from what the stage before has left, and nothing else.
  virtual Status begin() = 0;
  // Begins from that and from what settled() returned when all was quiet. finish() follows.
  virtual Status begin_settled(Message settled) = 0;
  // Takes a message of another tile, or of an earlier life of this tile. `current` says whether the sender went by the
  // same routing table as this tile. Error internal when no program of the stage can have sent the message.
  virtual Status take(TileId from, bool current, Message message) = 0;
  // Works on all messages that were taken.
  virtual Status step() = 0;
  // Returns whether step() has something to do even without new messages.
  virtual bool due() const = 0;
  // Returns the messages for other tiles, with the tile for each, and forgets them. None is longer than
  // message_bytes_max.
  virtual std::vector<std::pair<TileId, Message>> messages() = 0;
  // These tiles (ascending) were reborn and know nothing. The program makes messages of all that they, and others by
  // way of them, may not have heard. The exchange cannot do this, because only the program knows what it has told them.
  virtual void replay_to(std::span<const TileId> reborn) = 0;

  // Writes to scratch what the program holds in memory beside the image.
  virtual Status put_aside() = 0;
  // Returns the whole state as bytes. REQUIRES: put_aside() and messages() were called.
  virtual Image save() = 0;
  // Restores the state from an image. Returns false when save() has not made these bytes for this tile, or when they do
  // not fit what stands on scratch beside them.
  virtual Result<bool> load(Image image, ImageOf whose) = 0;
  // pack() returns an image for another node, which includes what was put aside. load_packed() restores the state from
  // it, as load() does from an `earlier` one.
  virtual Result<Image> pack(Image image) = 0;
  virtual Result<bool> load_packed(Image packed) = 0;
  // Frees all memory that an image can restore, or that is not needed after the end of the stage.
  virtual void free() = 0;

  // After quiescence: returns enough to come to the end of the stage without other tiles.
  virtual Message settled() const = 0;
  // After quiescence: ends the stage. Called once.
  virtual Result<std::unique_ptr<Finished>> finish() = 0;

  virtual std::size_t memory() const = 0;
  virtual const ExchangeCounts& counts() const = 0;  // still right after free()
};

// Makes the programs of a stage. Outlives the programs.
class TilePrograms {
 public:
  virtual ~TilePrograms() = default;
  virtual std::unique_ptr<TileProgram> program_of(TileId tile) const = 0;
};

}  // namespace tessera
