#include "sim/proof/program_proof.h"

#include <algorithm>
#include <atomic>
#include <functional>
#include <mutex>
#include <optional>
#include <span>
#include <utility>

#include "sim/basics/workers.h"
#include "sim/control/program_frame.h"
#include "sim/gcode/lines.h"

namespace tiltfeed::sim {
namespace {

// Moves that are read while those before are held, the first ones, and moves that a thread holds at a time:
// fixed, so that nothing depends on the number of threads. At the end of a batch threads wait for the last
// chunk.
constexpr std::size_t kBatch = 32768, kFirstBatch = 2048, kChunk = 512;

/// Reads moves, some at a time.
class Moves {
 public:
  Moves(std::istream& in, const std::string& name, std::span<const config::Job> operations)
      : in_(in),
        lines_(in),
        name_(name),
        operations_(operations),
        reader_(operations.front().machine, operations.front().setup),
        frames_(operations.front().machine.model, operations.front().setup),
        frame_(name, operations) {}

  /// Up to about `most` more of one operation; none: the program is at its end.
  Result<void> read(std::size_t most, std::vector<ProgramMove>& moves) {
    moves.clear();
    if (frame_.operation() != operation_) begin_operation();
    while (moves.size() < most && !reader_.ended()) {
      const auto line = lines_.next();
      if (!line) break;
      bytes_ += line->size() + 1;
      if (!frame_.done())
        if (auto sound = frame_.take(*line); !sound) return sound;
      blocks_.clear();
      if (auto read = reader_.read_line(*line, blocks_); !read)
        return fail(read.error().code,
                    name_ + ":" + std::to_string(reader_.lines()) + ": " + read.error().message);
      for (const ControlBlock& block : blocks_) take(block, moves);
      if (frame_.operation() == operation_) continue;
      if (!moves.empty()) break;  // the line is the operation's mark
      begin_operation();
    }
    if (in_.bad()) return fail(Code::kIo, name_ + ": cannot be read to its end");
    return {};
  }
  /// What stands behind the last move, and that all is there that stands round them.
  Result<void> end() { return frame_.take_rest(lines_); }
  std::uint64_t blocks() const { return count_; }
  std::uint64_t bytes() const { return bytes_; }
  /// Of the moves that were read last, counted from 0.
  std::size_t operation() const { return operation_; }
  const MoveFrames& frames() const { return frames_; }
  /// Places that the program takes over from, since the last call.
  std::vector<ProgramMove> take_fresh() { return std::exchange(fresh_, {}); }

 private:
  void begin_operation() {
    operation_ = frame_.operation();
    const config::Job& job = operations_[operation_];
    reader_.use(job.setup);
    frames_ = MoveFrames(job.machine.model, job.setup);
  }
  void take(const ControlBlock& one, std::vector<ProgramMove>& moves) {
    const Block& block = one.block;
    if (block.op != Op::kRapid && block.op != Op::kFeed) return;
    if (one.tcp != tcp_) at_ = one.tcp ? frames_.tip_words(at_) : frames_.slide_words(at_);
    tcp_ = one.tcp;
    if (!std::exchange(goes_on_, block.goes_on)) ++count_;
    const ProgramMove move{one.fresh ? block.target : at_,
                           block.target,
                           block.op == Op::kRapid,
                           one.tcp,
                           block.line,
                           count_,
                           block.goes_on};
    (one.fresh ? fresh_ : moves).push_back(move);
    at_ = block.target;
  }

  std::istream& in_;
  Lines lines_;
  const std::string& name_;
  std::span<const config::Job> operations_;
  std::size_t operation_ = 0;
  ControlReader reader_;
  MoveFrames frames_;
  FrameCheck frame_;
  std::vector<ControlBlock> blocks_;
  std::vector<ProgramMove> fresh_;
  std::uint64_t count_ = 0, bytes_ = 0;
  Joints at_;
  bool tcp_ = false, goes_on_ = false;
};

/// Where the program takes over the tool may be in the part without touching its surface.
void look_inside(const OperationProof& held, std::size_t operation, const std::vector<ProgramMove>& places,
                 ProgramProof& result) {
  const Prover& prover = *held.prover;
  for (const ProgramMove& place : places) {
    if (held.check != nullptr) result.add(held.check->look(place), operation);
    const Pose pose = prover.frames().pose(place.to, place.tcp);
    if (result.inside || !prover.inside(pose)) continue;
    result.inside = true;
    result.gouging = operation;
    result.proof.deepest = ProvenGouge{
        ToolPart::kCutter, prover.depth_inside(pose), place.rapid, place.line, place.block, pose, 0};
  }
}

}  // namespace

namespace {

/// What of the program is done, from the middle of a batch too, said by any thread.
class Shares {
 public:
  Shares(const std::function<bool(double share)>& report, double size) : report_(report), size_(size) {}

  /// A batch begins of so many chunks; it reaches to the program's byte `end`.
  void begin(std::size_t chunks, std::uint64_t end) {
    from_ = to_, to_ = std::min(1.0, static_cast<double>(end) / size_);
    chunks_ = chunks, done_ = 0;
  }
  /// A chunk is done.
  void next() {
    const std::lock_guard lock(mutex_);
    ++done_;
    const double share = from_ + (to_ - from_) * static_cast<double>(done_) / static_cast<double>(chunks_);
    if (report_ && !stopped_ && !report_(share)) stopped_ = true;
  }
  bool stopped() const { return stopped_; }

 private:
  const std::function<bool(double share)>& report_;
  const double size_;
  std::mutex mutex_;
  double from_ = 0.0, to_ = 0.0;
  std::size_t chunks_ = 1, done_ = 0;
  std::atomic<bool> stopped_ = false;
};

}  // namespace

void ProgramProof::add(Collisions found, std::size_t operation) {
  if (found.places.empty()) return;
  if (collisions.places.empty()) colliding = operation;
  if (colliding == operation) collisions.add(std::move(found));
}

Result<ProgramProof> prove_program(std::istream& in, const std::string& name,
                                   std::span<const config::Job> operations,
                                   const std::vector<OperationProof>& held, int threads,
                                   const std::function<bool(double share)>& progress) {
  const auto size = std::max<std::streamoff>(1, in.seekg(0, std::ios::end).tellg());
  in.clear();
  in.seekg(0);
  Moves reader(in, name, operations);
  ProgramProof result;
  std::vector<ProgramMove> now, next;
  Result<void> read = reader.read(kFirstBatch, now);
  if (!read) return tl::unexpected(read.error());
  Shares shares(progress, static_cast<double>(size));
  std::size_t before = 0;
  double known = 0.0;  // how deep the operation's batches before are in its part
  while (true) {
    const std::size_t operation = reader.operation();
    const Prover* const prover = held[operation].prover;
    const CollisionCheck* const check = held[operation].check;
    if (std::exchange(before, operation) != operation) known = 0.0;
    look_inside(held[operation], operation, reader.take_fresh(), result);
    std::vector<Proof> proofs((now.size() + kChunk - 1) / kChunk);
    std::vector<Collisions> collisions(proofs.size());
    const PairSet told = operation == result.colliding ? CollisionCheck::told(result.collisions) : 0;
    shares.begin(proofs.size(), reader.bytes());
    in_parallel(proofs.size() + 1, threads, [&](std::size_t i) {
      if (i == 0) {
        read = reader.read(kBatch, next);
        return;
      }
      if (shares.stopped()) return;
      const std::size_t first = (i - 1) * kChunk;
      const auto moves = std::span(std::as_const(now)).subspan(first, std::min(kChunk, now.size() - first));
      proofs[i - 1] = prover->hold(moves, known);
      if (check != nullptr) collisions[i - 1] = check->hold(moves, told);
      shares.next();
    });
    const double deepest = result.proof.deepest ? result.proof.deepest->depth : 0.0;
    for (const Proof& proof : proofs) result.proof.add(proof), known = std::max(known, proof.gouge);
    if (result.proof.deepest && result.proof.deepest->depth > deepest) result.gouging = operation;
    for (Collisions& some : collisions) result.add(std::move(some), operation);
    if (!read) return tl::unexpected(read.error());
    if (shares.stopped()) return fail(Code::kCancelled, "the proof was cancelled");
    if (next.empty()) break;
    std::swap(now, next);
  }
  if (auto sound = reader.end(); !sound) return tl::unexpected(sound.error());
  look_inside(held[reader.operation()], reader.operation(), reader.take_fresh(), result);
  if (const CollisionCheck* const check = held[result.colliding].check) check->measure(result.collisions);
  result.blocks = reader.blocks();
  if (result.proof.moves == 0) return fail(Code::kInput, name + ": no motion after its first block");
  return result;
}

Result<ToolPath> moves_between(std::istream& in, const std::string& name,
                               std::span<const config::Job> operations, std::uint64_t first,
                               std::uint64_t last) {
  in.clear();
  in.seekg(0);
  Moves reader(in, name, operations);
  ToolPath path;
  std::vector<ProgramMove> moves;
  while (true) {
    if (auto read = reader.read(kChunk, moves); !read) return tl::unexpected(read.error());
    const MoveFrames& frames = reader.frames();
    for (const ProgramMove& move : moves) {
      if (move.block < first || move.block > last) continue;
      const MoveKind kind = move.rapid ? MoveKind::kRapid : MoveKind::kCut;
      if (path.moves.empty())
        path.moves.push_back({frames.pose(move.from, move.tcp), MoveKind::kRapid, kNoFacet});
      path.moves.push_back({frames.pose(move.to, move.tcp), kind, kNoFacet});
    }
    if (moves.empty() || reader.blocks() > last) return path;
  }
}

}  // namespace tiltfeed::sim
