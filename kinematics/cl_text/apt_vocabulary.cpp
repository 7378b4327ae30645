#include "kinematics/cl_text/apt_vocabulary.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <vector>

namespace tiltfeed {
namespace {

// What the reader acts on, as far as a misspelling of it would lose a motion or a state of it.
constexpr std::array<std::string_view, 17> kMotions{"GOTO",   "GODLTA", "GOHOME", "FROM",  "RAPID",  "FEDRAT",
                                                    "CIRCLE", "CYCLE",  "CUTCOM", "UNITS", "TLAXIS", "MULTAX",
                                                    "LOADTL", "SPINDL", "DELAY",  "MSYS",  "CSYS"};
// Of these the ones that no option leaves out.
constexpr std::array<std::string_view, 10> kPoints{"GOTO",   "GODLTA", "GOHOME", "FROM",  "RAPID",
                                                   "CIRCLE", "CYCLE",  "TLAXIS", "UNITS", "UNIT"};
constexpr std::array<std::string_view, 55> kBends{
    "ROTABL", "ROTHED", "ROTATE",  "INDEX",  "TRACUT", "COPY",   "TRANS",   "ORIGIN", "MOVARC", "ARC",
    "ARCDAT", "ARCMOV", "MOVETO",  "HELIX",  "INDIRV", "INDIRP", "GO",      "GOFWD",  "GOLFT",  "GORGT",
    "GOUP",   "GODOWN", "GOBACK",  "TLON",   "TLLFT",  "TLRGT",  "SPLINE",  "NURBS",  "MIRROR", "SCALE",
    "POLYGN", "THREAD", "COORD",   "REFSYS", "CALL",   "MACRO",  "LOOPST",  "JUMPTO", "INCLUD", "POCKET",
    "PROBE",  "PLUNGE", "SURFACE", "RETRCT", "DNTCUT", "WCS",    "FIXTURE", "OFSTNO", "REPEAT", "PATERN",
    "GOCLER", "UNTIL",  "IF",      "PSIS",   "LEADIN"};
// In a word that is not known these speak of a motion, of a place that numbers count from, or of the tool.
constexpr std::array<std::string_view, 22> kMotionStems{
    "ROT",  "SWIV",   "TILT",  "PIVOT", "INDEX", "MOV",   "RETR",  "HOME",  "SHIFT", "TRANSL", "TRAFO",
    "MIRR", "OFFSET", "DATUM", "ZERO",  "INCR",  "PLANE", "FRAME", "WORLD", "TOOL",  "CSYS",   "MSYS"};
constexpr std::array<std::string_view, 32> kInforms{"TOOLPATH",
                                                    "MACHIN",
                                                    "TOLER",
                                                    "INTOL",
                                                    "OUTTOL",
                                                    "NOPOST",
                                                    "CLPRNT",
                                                    "TPRINT",
                                                    "REMARK",
                                                    "PAINT",
                                                    "PREFUN",
                                                    "SEQNO",
                                                    "LEADER",
                                                    "DISPLY",
                                                    "SELECT",
                                                    "SELCTL",
                                                    "SETUP",
                                                    "CSI_SET_FLUTE_LENGTH",
                                                    "ISN",
                                                    "LINTOL",
                                                    "SYN",
                                                    "HEADER",
                                                    "MCHTOL",
                                                    "CUT",
                                                    "CSI_SET_EXTENSION_LENGTH",
                                                    "PPTOL",
                                                    "REWIND",
                                                    "TMARK",
                                                    "PROGRM",
                                                    "OPNAME",
                                                    "CHECK",
                                                    "VERIFY"};

template <std::size_t N>
bool among(const std::array<std::string_view, N>& words, std::string_view word) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

/// Letters to change, add, take away or swap to come from one word to the other.
std::size_t edits(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before(b.size() + 1), last(b.size() + 1), now(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) last[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    now[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      now[j] = std::min({last[j] + 1, now[j - 1] + 1, last[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        now[j] = std::min(now[j], before[j - 2] + 1);
    }
    before = last;
    last = now;
  }
  return last[b.size()];
}

/// The motion word that this may be, or nothing.
std::string_view misspelt(const std::string& word) {
  constexpr std::size_t kLongest = 12;
  for (const std::string_view one : kMotions) {
    // GOTO1,2,3: its slash is missing.
    const bool runs_on = word.starts_with(one) && word.size() > one.size() &&
                         !(word[one.size()] >= 'A' && word[one.size()] <= 'Z') && word[one.size()] != '-';
    if (runs_on) return one;
    if (word.size() <= kLongest && edits(word, one) <= (one.size() > 5 ? 2u : 1u)) return one;
  }
  return {};
}

/// INSERT/ goes to the control as it stands: a block, N10 G0 X5, and no remark.
bool is_text_of_control(const AptRecord& record) {
  constexpr std::string_view kCodes = "NGML/";
  const auto digit = [](char c) { return c >= '0' && c <= '9'; };
  return record.word == "INSERT" && record.text.size() > 1 && kCodes.find(record.text[0]) != kCodes.npos &&
         digit(record.text[1]);
}

/// It moves or turns nothing: all of its numbers are zero, or it states an identity.
bool does_nothing(const AptRecord& record) {
  if (record.has("OFF") || record.has("NOMORE")) return true;
  std::array<double, 12> v{};
  std::size_t count = 0;
  if (record.numbers(v, count) || count == 0) return false;
  if (record.word == "TRANS" || record.word == "ORIGIN")
    return count <= 3 && std::all_of(v.begin(), v.end(), [](double one) { return one == 0.0; });
  constexpr std::array<double, 12> kIdentity{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  return record.word == "TRACUT" && count == 12 && v == kIdentity;
}

}  // namespace

bool only_informs(const AptRecord& record) {
  return among(kInforms, record.word) || (among(kBends, record.word) && does_nothing(record));
}

AptVerdict must_not_be_dropped(const AptRecord& record) {
  const std::string& word = record.word;
  const std::string leave = "; if it means nothing here, say --ignore " + word;
  if (among(kBends, std::string_view(word).substr(0, word.find_first_of(",("))))
    return mistake(
        word +
        "/ asks for more than the points that follow; let the CAM system write these alone, in the "
        "part's frame" +
        leave);
  if (word.find('=') != std::string::npos)
    return mistake("\"" + word +
                   "\" is of an APT part program; the post reads CL records (GOTO/x,y,z,i,j,k)");
  if (const std::string_view one = misspelt(word); !one.empty())
    return mistake("\"" + word + "\" is no known word; is it " + std::string(one) + "/ misspelt?" + leave);
  if (is_text_of_control(record))
    return mistake(word + "/ has words of a control (\"" + record.text + "\"), which the post cannot follow" +
                   leave);
  const auto stem = std::find_if(kMotionStems.begin(), kMotionStems.end(),
                                 [&](std::string_view one) { return word.find(one) != word.npos; });
  if (stem != kMotionStems.end())
    return mistake("\"" + word + "\" is no known word, and sounds like a motion (" + std::string(*stem) +
                   ")" + leave);
  constexpr std::size_t kPlace = 2;  // so many numbers may be a place or a direction
  if (record.count_numbers() >= kPlace)
    return mistake("\"" + word + "\" is no known word and has numbers like a motion" + leave);
  return std::nullopt;
}

bool is_motion_word(const std::string& word) { return among(kPoints, word); }

}  // namespace tiltfeed
