#pragma once
// What a machine profile says about the wire beside its address: the section `wire` of the profile file.
// Every key: config/machines/generic-ac.yaml.

#include <cstdint>

namespace tiltfeed {

/// Where the ring of a Modbus controller lies and how it counts. Addresses are 0-based holding registers.
struct RingMap {
  std::uint16_t identity = 0x0000, window = 0x0100, mailbox = 0x0180, status = 0x0200, heartbeat = 0x0240;
  bool low_word_first = false;  ///< of 32-bit values
  int linear_exponent = -1;     ///< a position word counts 10^-exponent mm; -1: as the identity says
  int rotary_exponent = -1;     ///< likewise degrees
  double watchdog = 1.0;        ///< s without a heartbeat after which the controller holds
};

enum class Parity : std::uint8_t { kNone, kEven, kOdd };
enum class FlowControl : std::uint8_t { kNone, kXonXoff, kRtsCts };
enum class EndOfBlock : std::uint8_t { kLf, kCrLf, kCr, kLfCrCr };

/// How a CNC control wants a program on its serial port (drip feed).
struct DripFormat {
  int data_bits = 7;
  Parity parity = Parity::kEven;
  int stop_bits = 2;
  FlowControl flow = FlowControl::kXonXoff;
  EndOfBlock end_of_block = EndOfBlock::kLf;
  int leader = 0, trailer = 0;   ///< NUL bytes before the first and after the last byte
  bool percent = true;           ///< % before and after the program
  bool wait_for_start = true;    ///< nothing is sent before the control's DC1
  char xon = 0x11, xoff = 0x13;  ///< DC1 and DC3, unless the control uses others
};

/// Everything above, and what a Grbl or RepRap controller does not tell by itself.
struct LinkProfile {
  RingMap ring;
  DripFormat drip;
  int reprap_window = 0;      ///< unanswered lines; 0: by its M115, else 1
  bool line_numbers = false;  ///< N words for grblHAL's Ln: feedback
  bool check = false;         ///< let a Grbl controller read the program first ($C)
};

class Section;
class Description;

/// Reads the section `wire` of a machine profile, which may be absent. Complaints go to the section.
LinkProfile read_link_profile(const Section& root);
void describe(const LinkProfile& profile, Description& out);

}  // namespace tiltfeed
