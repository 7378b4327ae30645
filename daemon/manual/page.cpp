#include "daemon/manual/page.h"

#include <algorithm>
#include <cstdio>
#include <sstream>

namespace tiltfeed::daemon {

namespace {

constexpr std::size_t kColumns = 79, kIndent = 4;

std::string upper(std::string text) {
  for (char& c : text)
    if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
  return text;
}

/// Words of a paragraph in lines of at most `columns` bytes, longer words alone.
std::vector<std::string> wrapped(const std::string& text, std::size_t columns) {
  std::vector<std::string> lines(1);
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    if (!lines.back().empty() && lines.back().size() + 1 + word.size() > columns) lines.emplace_back();
    lines.back() += (lines.back().empty() ? "" : " ") + word;
  }
  return lines;
}

/// The code point that begins at `i`; moves on to its last byte.
unsigned code_point(const std::string& text, std::size_t& i) {
  const auto byte = [&](std::size_t at) { return static_cast<unsigned char>(text[at]); };
  const unsigned first = byte(i);
  const int more = first >= 0xF0 ? 3 : first >= 0xE0 ? 2 : first >= 0xC0 ? 1 : 0;
  unsigned code = more == 0 ? first : first & (0x3FU >> more);
  for (int k = 0; k < more && i + 1 < text.size(); ++k) code = code << 6 | (byte(++i) & 0x3FU);
  return code;
}

/// A line of text: nothing in it is a request or an escape.
std::string escaped(const std::string& text) {
  std::string out;
  if (!text.empty() && (text[0] == '.' || text[0] == '\'')) out = "\\&";
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '\\') {
      out += "\\e";
    } else if (c == '-') {
      out += "\\-";
    } else if (static_cast<unsigned char>(c) < 0x80) {
      out += c;
    } else {
      char code[16];
      std::snprintf(code, sizeof code, "\\[u%04X]", code_point(text, i));
      out += code;
    }
  }
  return out;
}

/// An argument of a macro.
std::string quoted(const std::string& text) {
  std::string out;
  for (const char c : escaped(text)) out += c == '"' ? "\\(dq" : std::string(1, c);
  return "\"" + out + "\"";
}

std::string paragraph(const std::string& text) {
  std::string out;
  // Escapes are longer than what they stand for: a third is left for them.
  for (const std::string& line : wrapped(text, kColumns * 2 / 3)) out += escaped(line) + "\n";
  return out;
}

std::string source_lines(const std::string& text) {
  std::string out = ".RS 4\n.nf\n";
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) out += line.empty() ? ".sp\n" : escaped(line) + "\n";
  return out + ".fi\n.RE\n";
}

std::string indented(const std::string& text, std::size_t by) {
  std::string out;
  for (const std::string& line : wrapped(text, kColumns - by)) out += std::string(by, ' ') + line + "\n";
  return out;
}

}  // namespace

std::string man_text(const Page& page, const std::string& date, const std::string& version) {
  const std::string section = std::to_string(page.section);
  std::string out = ".TH " + quoted(upper(page.name)) + " " + section + " " + "\"" + date + "\" " +
                    quoted("Tiltfeed " + version) + " " + quoted("Tiltfeed") + "\n";
  out += ".SH NAME\n" + paragraph(page.name + " - " + page.what);
  PartKind before = PartKind::kHeading;
  bool fresh = true;  // after a heading no paragraph is opened
  for (const Part& part : page.parts) {
    if (part.kind == PartKind::kHeading) out += ".SH " + quoted(upper(part.text)) + "\n";
    if (part.kind == PartKind::kSubheading) out += ".SS " + quoted(part.text) + "\n";
    if (part.kind == PartKind::kText) out += (fresh ? "" : ".PP\n") + paragraph(part.text);
    if (part.kind == PartKind::kItem && part.term.empty()) out += ".IP \\(bu 3\n" + paragraph(part.text);
    if (part.kind == PartKind::kItem && !part.term.empty())
      out += ".TP\n.B " + quoted(part.term) + "\n" + (part.text.empty() ? "\\&\n" : paragraph(part.text));
    if (part.kind == PartKind::kSource)
      out += (fresh || before == PartKind::kItem ? "" : ".PP\n") + source_lines(part.text);
    fresh = part.kind == PartKind::kHeading || part.kind == PartKind::kSubheading;
    before = part.kind;
  }
  return out;
}

std::string plain_text(const Page& page) {
  std::string out = page.name + ": " + page.what + "\n";
  PartKind before = PartKind::kText;
  for (const Part& part : page.parts) {
    const bool list = part.kind == PartKind::kItem && before == PartKind::kItem;
    if (!list) out += "\n";
    if (part.kind == PartKind::kHeading) out += upper(part.text) + "\n";
    if (part.kind == PartKind::kSubheading) out += part.text + "\n";
    if (part.kind == PartKind::kText) out += indented(part.text, 0);
    if (part.kind == PartKind::kItem && part.term.empty())
      out += "  *" + indented(part.text, kIndent).substr(3);
    if (part.kind == PartKind::kItem && !part.term.empty())
      out += "  " + part.term + "\n" + (part.text.empty() ? "" : indented(part.text, 2 * kIndent));
    if (part.kind == PartKind::kSource) out += part.text;
    before = part.kind;
  }
  return out;
}

}  // namespace tiltfeed::daemon
