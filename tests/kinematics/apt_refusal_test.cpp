// What a CL file may not ask for: each is refused where it stands, none is dropped.

#include <gtest/gtest.h>

#include "tests/texts/apt_text.h"

namespace tiltfeed {
namespace {

struct Bad {
  const char* text;
  const char* place;    ///< line:column
  const char* message;  ///< a part of it
};

void expect_refused(const std::vector<Bad>& table) {
  for (const Bad& bad : table) {
    SCOPED_TRACE(bad.text);
    const auto program = read_text(bad.text);
    ASSERT_FALSE(program) << "accepted";
    EXPECT_EQ(program.error().code, Code::kInput);
    const std::string& message = program.error().message;
    const std::string head = std::string("p.cls:") + bad.place + ": ";
    EXPECT_EQ(message.substr(0, head.size()), head) << message;
    EXPECT_NE(message.find(bad.message), std::string::npos) << message;
  }
}

TEST(AptRefusal, WordsThatMoveOrTurnWhatFollows) {
  expect_refused({
      {"UNITS/MM\n  TRACUT/0,1,0,5,1,0,0,0,0,0,1,0\n", "2:3", "TRACUT/ asks for more"},
      {"TRANS/1,0,0\n", "1:1", "TRANS/ asks for more"},
      {"ORIGIN/0,0,5\n", "1:1", "say --ignore ORIGIN"},
      {"COPY/1,TRANSL,5,0,0,3\n", "1:1", "COPY/ asks for more"},
      {"INDEX/1\n", "1:1", "INDEX/ asks"},
      {"ROTATE/AAXIS,ABS,30\n", "1:1", "ROTATE/ asks"},
      {"ROTHED/30\n", "1:1", "ROTHED/ asks"},
      {"WCS/2\n", "1:1", "WCS/ asks"},
      {"FIXTURE/2\n", "1:1", "FIXTURE/ asks"},
      {"REPEAT/3\n", "1:1", "REPEAT/ asks"},
      {"TLON,GOFWD/L1\n", "1:1", "TLON,GOFWD/ asks"},
      {"PATERN/LINEAR,P1\n", "1:1", "PATERN/ asks"},
      {"GOCLER\n", "1:1", "GOCLER/ asks"},
      {"INDIRV/0,-1,0\n", "1:1", "INDIRV/ asks"},
      {"TLON,GOFWD/(CIRCLE/1,0,0,5),ON,(LINE/1,0,0,15,0,0)\n", "1:1", "asks for more"},
      {"MOVETO/1,2,3\n", "1:1", "MOVETO/ asks"},
      {"CALL/SUB1\n", "1:1", "CALL/ asks"},
      {"CSYS/0,1,0,5,-1,0,0,6,0,0,1,7\n", "1:1", "CSYS/: nothing states whether"},
      {"TRNTYP/WORLD,10,0,0\n", "1:1", "TRNTYP/ is understood as WORLD,0,0,0"},
      {"TRNTYP/LOCAL\n", "1:1", "say --ignore TRNTYP"},
      {"MSYS/0,0,0,1,0,0,1,0,0\n", "1:1", "not of length 1 and square"},
      {"MSYS/0,0,0,1,0,0\n", "1:1", "nine numbers"},
      {"TRNTYP/WORLD,0,0,0\nCSYS/1,0,0,0,0,1,0,0,0,0,-1,0\n", "2:1", "right-handed"},
      {"MODE/INCR\n", "1:1", "incremental points"},
      {"SET/MODE,INCR\n", "1:1", "incremental points"},
      {"UNITS/MM\nMULTAX/OFF\nGOTO/0,0,5,0,0,1\n", "3:12", "a direction after MULTAX/OFF"},
  });
  const auto harmless = read_text(
      "UNITS/MM\nTRANS/0,0,0\nORIGIN/0,0,0\nTRACUT/NOMORE\nTRACUT/1,0,0,0,0,1,0,0,0,0,1,0\nROTABL/OFF\n"
      "CSYS/1,0,0,0,0,1,0,0,0,0,1,0\nSET/MODE,ABSOL\nMULTAX/OFF\nGOTO/0,0,5\nMULTAX/ON\nGOTO/0,0,5,0,0,1\n",
      {});
  ASSERT_FALSE(harmless);
  EXPECT_NE(harmless.error().message.find("p.cls:12:1: no FEDRAT/ yet"), std::string::npos)
      << "none of the others is refused: " << harmless.error().message;
}

TEST(AptRefusal, WhatLooksLikeAMotion) {
  expect_refused({
      {"GOTTO/5,0,0\n", "1:1", "is it GOTO/ misspelt?"},
      {"GTO/5\n", "1:1", "is it GOTO/ misspelt?"},
      {"GOTO1,2,3\n", "1:1", "is it GOTO/ misspelt?"},
      {"GODLAT/1\n", "1:1", "is it GODLTA/ misspelt?"},
      {"RAPPID\n", "1:1", "is it RAPID/ misspelt?"},
      {"FEDRTA/100\n", "1:1", "is it FEDRAT/ misspelt?"},
      {"CYCEL/OFF\n", "1:1", "is it CYCLE/ misspelt?"},
      {"\nWHATEVER/1,2\n", "2:1", "numbers like a motion; if it means nothing here, say --ignore WHATEVER"},
      {"P1=POINT/1,2,3\n", "1:1", "APT part program"},
      {"RETRCT/50\n", "1:1", "RETRCT/ asks"},
      {"DNTCUT\n", "1:1", "DNTCUT/ asks"},
      {"ROTTABLE/90\n", "1:1", "sounds like a motion (ROT)"},
      {"SWIVEL/A,90\n", "1:1", "sounds like a motion (SWIV)"},
      {"SETDATUM/5\n", "1:1", "sounds like a motion (DATUM)"},
      {"CHANGETOOL/5\n", "1:1", "sounds like a motion (TOOL)"},
      {"MODE/RELATIVE\n", "1:1", "MODE/ is understood as ABSOL"},
      {"INSERT/G91 G0 X5\n", "1:1", "has words of a control (\"G91 G0 X5\")"},
      {"INSERT/M21\n", "1:1", "has words of a control"},
  });
  for (const char* remark :
       {"INSERT/Stock Size X293.7 Y100. Z9.", "INSERT/14MM CRB 4FL 32 LOC", "INSERT/GAGE 7"})
    EXPECT_TRUE(read_text("UNITS/MM\n" + std::string(remark) + "\nGOTO/0,0,0\nFINI\n")) << remark;
}

TEST(AptRefusal, MotionsBehindTheEnd) {
  expect_refused({
      {"UNITS/MM\nGOTO/0,0,0\nFINI\nGOTO/0,0,-9\n", "4:1", "behind the file's end (FINI or END) in line 3"},
      {"UNITS/MM\nGOTO/0,0,0\nEND\nPARTNO/2\nGODLTA/0,0,-9\nFINI\n", "5:1", "behind the file's end"},
  });
  EXPECT_TRUE(read_text("UNITS/MM\nGOTO/0,0,0\nFINI\n\n$$ a remark\n\x1a"));
}

TEST(AptRefusal, MotionsFromAPlaceThatIsNotKnown) {
  const std::string head = "UNITS/MM\nFEDRAT/9\nGOTO/0,0,50\nFROM/0,0,100\n";
  expect_refused({
      {(head + "GODLTA/1,0,0\n").c_str(), "5:1", "FROM/ states another place than the last point"},
      {(head + "CYCLE/DRILL,FEDTO,3,RAPTO,1\nGOTO/0,0,0\n").c_str(), "6:1", "FROM/ states another place"},
      {(head + "CIRCLE/5,0,50,0,0,1\nGOTO/5,5,50\n").c_str(), "6:1", "FROM/ states another place"},
  });
  EXPECT_TRUE(read_text(head + "GOTO/1,0,0\nGODLTA/1,0,0\nFINI\n"));
  EXPECT_TRUE(read_text("UNITS/MM\nFEDRAT/9\nGOTO/0,0,50\nFROM/0,0,50\nGODLTA/1,0,0\nFINI\n"));
  EXPECT_TRUE(read_text("UNITS/MM\nFEDRAT/9\nGOTO/0,0,50\nLOADTL/2\nFROM/0,0,100\nGODLTA/1,0,0\nFINI\n"));
}

TEST(AptRefusal, DecimalCommas) {
  expect_refused({
      {"GOTO/1,5,2,5,3,5,0,0,1\n", "1:12", "is a comma used as decimal point?"},
      {"GOTO/1,5,2,5,3,5\n", "1:12", "is a comma used as decimal point?"},
      {"GOTO/1,5,2,5\n", "1:1", "is a comma used as decimal point?"},
      {"FEDRAT/100,5,MMPM\n", "1:12", "is a comma used as decimal point?"},
      {"DELAY/1,5\n", "1:9", "is a comma used as decimal point?"},
      {"SPINDL/1000,5,RPM,CLW\n", "1:13", "is a comma used as decimal point?"},
      {"LOADTL/3,LENGTH,100,5\n", "1:21", "is a comma used as decimal point?"},
      {"CYCLE/DRILL,FEDTO,5,MMPM,207,5,RAPTO,3\n", "1:30", "what the number 5 means is not clear"},
  });
}

TEST(AptRefusal, UnitsThatComeTooLate) {
  expect_refused({
      {"GOTO/0,0,0\nUNITS/INCHES\n", "2:1", "stands behind the first motion, which was read in mm"},
      {"GOTO/0,0,0\nUNIT/MM\n", "2:1", "stands behind the first motion"},
      {"UNITS/MM\nGOTO/0,0,0\nUNITS/INCH\n", "3:1", "read in another unit"},
      {"UNITS/MM\nUNITS/INCHES\nGOTO/0,0,0\n", "2:1", "two units are stated"},
      {"UNIT/FEET\n", "1:1", "UNIT/ wants MM, CM or INCHES"},
  });
}

TEST(AptRefusal, Cycles) {
  expect_refused({
      {"CYCLE/THREAD,5\n", "1:7", "only DRILL"},
      {"CYCLE/\n", "1:6", "only DRILL"},
      {"CYCLE/DRILL,RAPTO,3\n", "1:19", "no depth"},
      {"CYCLE/DRILL,FEDTO,3\n", "1:19", "no clearance"},
      {"CYCLE/DEEP,FEDTO,3,RAPTO,1\n", "1:26", "no step"},
      {"CYCLE/DEEP,FEDTO,3,RAPTO,1,STEP,1e-9\n", "1:33", "no more than 10000"},
      {"CYCLE/DRILL,FEDTO,3,RAPTO,1,ORIENT,90\n", "1:29", "\"ORIENT\" is not understood"},
      {"CYCLE/DRILL,5,100,MMPM,3\n", "1:15", "what the number 100 means is not clear"},
      {"CYCLE/DRILL,FEDTO,x\n", "1:13", "FEDTO has no number"},
      {"UNITS/MM\nGOTO/0,0,9\nCYCLE/DRILL,FEDTO,3,RAPTO,1\nGOTO/0,0,0\n", "4:1", "no FEDRAT/ yet"},
      {"UNITS/MM\nGOTO/0,0,9\nFEDRAT/9\nCYCLE/DRILL,FEDTO,3,RAPTO,1\nRAPID\nGOTO/0,0,0\n", "6:1",
       "RAPID while a CYCLE/ is on"},
      {"UNITS/MM\nGOTO/0,0,9\nFEDRAT/9\nCYCLE/DRILL,FEDTO,3,RAPTO,1\nGOTO/0,0,0\nGOTO/9,0,0,1,0,0\n", "6:1",
       "turns between two holes"},
      {"UNITS/MM\nGOTO/0,0,9\nFEDRAT/9\nCYCLE/DRILL,FEDTO,3,RAPTO,1\nGOTO/0,0,0\nCYCLE/OFF\n"
       "CYCLE/BORE,FEDTO,3,RAPTO,1\nGOTO/9,0,0,1,0,0\n",
       "8:1", "turns between two holes"},
      {"FEDRAT/9\nCYCLE/DRILL,FEDTO,3,RAPTO,1\nGOTO/0,0,0\nLOAD/TOOL,2\n", "4:1", "while CYCLE/ is on"},
      {"UNITS/MM\nGOTO/0,0,9\nFEDRAT/9\nCYCLE/TAP,FEDTO,3,RAPTO,1\nGOTO/0,0,0\n", "5:1", "spindle speed"},
  });
}

TEST(AptRefusal, Arcs) {
  const std::string from = "UNITS/MM\nFEDRAT/9\nGOTO/10,0,0\n";
  expect_refused({
      {"CIRCLE/0,0,0,0,0,1,10,TIMES,2\n", "1:1", "several turns"},
      {"CIRCLE/0,0,0,0,0\n", "1:1", "has 5 numbers"},
      {"CIRCLE/0,0,0,0,0,2\n", "1:14", "axis is not of length 1"},
      {"UNITS/MM\nFEDRAT/9\nGOTO/10,0,0\nCIRCLE/0,0,0,0,0,1\nGOTO/0,9,0\n", "5:1",
       "10 and 9 mm from its centre"},
      {"UNITS/MM\nFEDRAT/9\nGOTO/10,0,0\nCIRCLE/10,0,0,0,0,1\nGOTO/0,10,0\n", "5:1", "a centre that one"},
      {"UNITS/MM\nFEDRAT/9\nGOTO/10,0,0\nCIRCLE/0,0,0,0,0,1,12\nGOTO/0,10,0\n", "5:1",
       "CIRCLE/ states 12 mm"},
      {"UNITS/MM\nFEDRAT/9\nGOTO/10,0,0\nCIRCLE/0,0,0,0,0,1,0\nGOTO/0,10,0\n", "5:1", "CIRCLE/ states 0 mm"},
      {"UNITS/MM\nFEDRAT/9\nGOTO/10,0,0\nCIRCLE/0,0,0,0,0,1\nRAPID\n", "5:1", "without GOTO/ behind it"},
      {"UNITS/MM\nFEDRAT/9\nGOTO/10,0,0\nCIRCLE/0,0,0,0,0,1\nGOTO/0,10,0,1,0,0\n", "5:1",
       "turns along the arc"},
      {"UNITS/MM\nFEDRAT/9\nCIRCLE/0,0,0,0,0,1\nGOTO/0,10,0\n", "4:1", "an arc in rapid"},
      {"UNITS/MM\nFEDRAT/9\nGOTO/10,0,0\nCIRCLE/0,0,0,0,0,-1,10\nGOTO/0,10,0\nGOTO/-10,0,0\n", "6:1",
       "do not go round in its axis's sense"},
  });
}

TEST(AptRefusal, Compensation) {
  expect_refused({
      {"CUTCOM/ON\n", "1:8", "\"ON\" is not understood"},
      {"CUTCOM/LEFT,RIGHT\n", "1:1", "wants LEFT, RIGHT or OFF"},
      {"CUTCOM/LEFT,ZXPLAN\n", "1:13", "\"ZXPLAN\" is not understood"},
      {"CUTCOM/LEFT,1.5\n", "1:1", "wants a register"},
      {"CUTCOM/LEFT\nLOADTL/2\n", "2:1", "while CUTCOM/ is on"},
      {"LOADTL/7,ADJUST,PLUS\n", "1:1", "wants a register"},
  });
}

}  // namespace
}  // namespace tiltfeed
