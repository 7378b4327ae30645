// The reports of the Grbl firmware model: status, build, settings, parser state.

#include <array>
#include <charconv>

#include "sim/controller/grbl_controller.h"

namespace tiltfeed::sim {
namespace {

/// The work offset comes with every tenth report of a machine that stands, with every thirtieth of one that
/// moves.
constexpr int kOffsetStanding = 10, kOffsetMoving = 30;
/// And so the overrides, where they do not change.
constexpr int kOverridesStanding = 10, kOverridesMoving = 20;

void put(std::string& out, double value, int decimals) {
  std::array<char, 350> text;  // the longest double with 3 decimals
  const char* const end =
      std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::fixed, decimals).ptr;
  out.append(text.data(), static_cast<std::size_t>(end - text.data()));
}

}  // namespace

/// "SF": what is on, as the firmware's A: field has it.
std::string GrblController::accessories() const {
  const Accessories& on = motion_.accessories();
  std::string text;
  if (on.spindle > 0.0) text += on.reverse ? 'C' : 'S';
  if (on.flood) text += 'F';
  if (on.mist) text += 'M';
  return text;
}

std::string_view GrblController::state() const {
  if (alarm_ != 0) return "Alarm";
  if (check_mode_) return "Check";
  if (cycle_ == Cycle::kHome) return "Home";
  if (cycle_ == Cycle::kJog || cycle_ == Cycle::kCancel) return "Jog";
  if (motion_.held()) return motion_.standing() ? "Hold:0" : "Hold:1";
  const Block* running = motion_.running();
  // A dwell is reported as Idle, as the firmware does: Idle is not "finished".
  return running != nullptr && (running->op == Op::kRapid || running->op == Op::kFeed) ? "Run" : "Idle";
}

void GrblController::report_status() {
  out_ += '<';
  out_ += state();
  const GrblAxes at = offsets_.machine(motion_.position());
  out_ += "|MPos:" + grbl_text(at);
  out_ += "|Bf:" + std::to_string(motion_.free_slots()) + ',' +
          std::to_string(options_.rx_buffer - (rx_.size() - rx_read_));
  if (const Block* running = motion_.running()) out_ += "|Ln:" + std::to_string(running->line);
  out_ += "|FS:";
  put(out_, motion_.speed(), 0);
  out_ += ',';
  put(out_, motion_.accessories().spindle * spindle_override_ / 100.0, 0);
  if (options_.plate && at[2] <= *options_.plate) out_ += "|Pn:P";
  if (reports_to_offset_-- == 0) {
    const bool busy = motion_.held() || motion_.running() != nullptr;
    reports_to_offset_ = (busy ? kOffsetMoving : kOffsetStanding) - 1;
    out_ += "|WCO:" + grbl_text(offsets_.work());
  }
  const std::string on = accessories();
  if (reports_to_overrides_-- == 0) report_overrides_ = true;
  if (report_overrides_)
    reports_to_overrides_ = (motion_.running() != nullptr ? kOverridesMoving : kOverridesStanding) - 1;
  if (report_overrides_ || on != reported_accessories_) {
    out_ += "|Ov:" + std::to_string(motion_.feed_override()) + ',' +
            std::to_string(motion_.rapid_override()) + ',' + std::to_string(spindle_override_);
    if (!on.empty()) out_ += "|A:" + on;
  }
  report_overrides_ = false;
  reported_accessories_ = on;
  out_ += ">\r\n";
}

void GrblController::report_build() {
  const MachineModel& machine = motion_.machine();
  out_ += "[VER:1.1h.20260801:tiltfeed-sim]\r\n[OPT:VN," + std::to_string(options_.planner) + ',' +
          std::to_string(options_.rx_buffer) +
          "]\r\n[AXS:" + std::to_string(3 + machine.tilt.present + machine.rotary.present) + ":XYZ";
  if (machine.tilt.present) out_ += machine.tilt.letter;
  if (machine.rotary.present) out_ += machine.rotary.letter;
  out_ += "]\r\n";
}

void GrblController::report_parameters() {
  out_ += offsets_.report() + "[PRB:" + grbl_text(touched_) + (touches_ ? ":1" : ":0") + "]\r\n";
}

void GrblController::report_parser() {
  const ModalState& modal = reader_.modal();
  out_ += "[GC:";
  constexpr std::array<const char*, 5> kMotions{"G80", "G0", "G1", "G2", "G3"};
  out_ += kMotions[static_cast<std::size_t>(modal.motion)];
  out_ += " " + GrblOffsets::name(offsets_.selected()) + " G" + std::to_string(modal.plane) + " G21 ";
  out_ += modal.relative ? "G91 " : "G90 ";
  out_ += modal.inverse_time ? "G93" : "G94";
  const Accessories& on = motion_.accessories();
  out_ += on.spindle <= 0.0 ? " M5" : on.reverse ? " M4" : " M3";
  if (on.mist) out_ += " M7";
  if (on.flood) out_ += " M8";
  if (!on.mist && !on.flood) out_ += " M9";
  out_ += " T0 F";
  put(out_, modal.feed, 0);
  out_ += " S";
  put(out_, modal.spindle, 0);
  out_ += "]\r\n";
}

}  // namespace tiltfeed::sim
