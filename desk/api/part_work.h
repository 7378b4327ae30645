#pragma once
// The part on the desk: taken, read by a process of its own, drawn.

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "desk/http/http_message.h"
#include "desk/work/child_process.h"

namespace tiltfeed::desk {

/// Tells every page that listens: an event's name, and its JSON.
using Teller = std::function<void(const std::string&, const std::string&)>;

/// What a job says of the part besides its unit.
struct PartChoice {
  std::vector<std::string> bodies = {}, avoid = {};  ///< as PartAsked has them
  double deviation = 0.0;                            ///< mm; 0: nobody has said
  bool operator==(const PartChoice&) const = default;
};

class PartWork {
 public:
  /// `program`: what reads parts (this program); `folder`: where the part's files are kept.
  PartWork(std::string program, std::string folder, Teller tell)
      : program_(std::move(program)), folder_(std::move(folder)), tell_(std::move(tell)) {}

  /// Takes the file at `path` in place of the part before; it is read in the background.
  /// Errors: kUsage: no such unit; kIo.
  Result<void> take(const std::string& path, const std::string& name, const std::string& unit);
  /// Makes one of the formula parts and takes it. `maker`: tiltfeed-sim. Errors: kUsage: no such part; kIo.
  Result<void> make(const std::string& maker, const std::string& sample);
  /// What of it is drawn, and how finely, as the job has it; it is read again where that is not what is
  /// drawn.
  void choose(const PartChoice& choice);
  /// The same for the part that is taken next.
  void choose_for_next(const PartChoice& choice) { choice_ = choice; }
  /// Its facets are made of surfaces.
  bool has_surfaces() const;
  const PartChoice& choice() const { return choice_; }
  /// Reads the part again, as of another unit. Errors: kUsage: there is no part, or no such unit.
  Result<void> set_unit(const std::string& unit);

  /// JSON: null without a part; else id, name, unit, state (reading, ready, refused) and, when ready, what
  /// write_part_view() says of it.
  std::string describe() const;
  Reply mesh() const { return buffer("mesh.f32"); }
  Reply edges() const { return buffer("edges.f32"); }
  /// The face of each facet, of a file that has faces.
  Reply faces() const { return buffer("faces.u32"); }
  /// All bodies and faces of the file, JSON; of a part that was refused for the bodies that a job names, too.
  Reply model() const;
  /// Empty without a part that can be read: it is ready, or was, and is read again.
  std::string stl() const { return state_ == "ready" || (state_ == "reading" && readable_) ? stl_ : ""; }
  const std::string& unit() const { return unit_; }
  const std::string& name() const { return name_; }
  std::uint64_t id() const { return id_; }

  /// What to wait for; -1: nothing. And what to do when it is there.
  int descriptor() const { return child_ ? child_->descriptor() : -1; }
  void hear();

 private:
  Result<void> read();
  Reply buffer(const char* file) const;

  std::string program_, folder_;
  Teller tell_;
  std::uint64_t id_ = 0;  // of the part and its unit; 0: none
  std::string name_, unit_, stl_, state_, error_, seen_;
  std::string sample_;  // the part that is being made
  PartChoice choice_;
  bool readable_ = false;
  std::optional<ChildProcess> child_;
};

}  // namespace tiltfeed::desk
