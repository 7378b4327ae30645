#pragma once
// What the reader of program text must not take for what it knows: lines that would be misread, and how much
// it takes.

#include <cstddef>
#include <cstdint>
#include <iosfwd>
#include <optional>
#include <string>

#include "config/machine_profile.h"
#include "daemon/post/dialect_words.h"
#include "daemon/post/text_language.h"

namespace tiltfeed::daemon {

// A program that is longer has to be divided: its path is held in memory. About 60 bytes a block, 70 a point.
inline constexpr std::size_t kMostTextBlocks = 1'000'000;
inline constexpr std::size_t kMostTextPoints = 1'000'000;
inline constexpr std::uint32_t kMostTextLines = 3'000'000;
inline constexpr std::size_t kMostTextEvents = 200'000;
inline constexpr std::size_t kMostTextTools = 10'000;
inline constexpr std::uint64_t kMostTextBytes = 200'000'000;
inline constexpr std::size_t kLongestTextLine = 4096;

/// The profile's control and axes, and the M codes of its own lines (clamps, start, end).
TextLanguage text_language(const config::MachineProfile& machine);

/// Why the words of a line cannot be read one by one, or are not known; nothing: they can.
std::optional<std::string> misread(const DialectWords& words, const TextLanguage& language, bool incremental);

/// Whether a G code (in tenths) calls a work offset of the control; G54.1 and G154 do so with P.
bool is_work_offset(int tenths, config::Dialect dialect);

enum class LineRead { kLine, kEnd, kTooLong };
/// The next line without its end (LF, CR LF, or CR alone), of at most `most` bytes.
LineRead read_bounded_line(std::istream& in, std::string& line, std::size_t most);

}  // namespace tiltfeed::daemon
