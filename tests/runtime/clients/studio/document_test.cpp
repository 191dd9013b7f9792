// The document of the Studio: undo, saving, and what is left beside the file.
#include "runtime/clients/studio/live/document.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "runtime/files.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;
using nlohmann::json;
using studio::Document;

const std::string kDocumentText = "# kept\nterrazzo: 1\nnodes:\n  a: {type: Constant, params: {value: 5}}\n";

Edit value(const std::string& v) { return {Edit::Kind::SetParameter, "a", "value", {false, {v}, {}}}; }

class StudioDocument : public ::testing::Test {
 protected:
  StudioDocument() { write_text_atomically(file, kDocumentText); }
  std::string beside() const { return read_file(file.parent_path() / ".graph.yaml.unsaved").value_or(""); }
  const fs::path file = test::temporary_folder() / "graph.yaml";
  const fs::path second = file.parent_path() / ".graph.yaml.unsaved_2";
};

TEST_F(StudioDocument, UndoGoesBackToTheFirstTextAndForward) {
  Document d(file);
  std::vector<std::string> texts{d.text()};
  for (int k = 0; k < 50; ++k) {
    d.edit({value(std::to_string(k))});
    texts.push_back(d.text());
  }
  for (std::size_t k = texts.size() - 1; k-- > 0;) {
    EXPECT_TRUE(d.undo());
    EXPECT_EQ(d.text(), texts[k]);
  }
  EXPECT_FALSE(d.undo());
  EXPECT_TRUE(d.saved());
  while (d.redo()) {
  }
  EXPECT_EQ(d.text(), texts.back());
}

TEST_F(StudioDocument, AMovingSliderIsOneStep) {
  Document d(file);
  d.edit({value("6")});
  for (const char* v : {"7", "8", "9"}) d.edit({value(v)}, "first");
  for (const char* v : {"10", "11"}) d.edit({value(v)}, "second");
  EXPECT_TRUE(d.undo());
  EXPECT_NE(d.text().find("value: 9"), std::string::npos);
  EXPECT_TRUE(d.undo());
  EXPECT_NE(d.text().find("value: 6"), std::string::npos);
}

TEST_F(StudioDocument, SeveralEditsAreOneStepOrNone) {
  Document d(file);
  EXPECT_EQ(test::code_of([&] {
              d.edit({value("6"), {Edit::Kind::RemoveNode, "nothing"}});
            }),
            "unknown-node");
  EXPECT_EQ(d.text(), kDocumentText);
  EXPECT_FALSE(d.can_undo());
}

TEST_F(StudioDocument, UnsavedTextIsKeptBesideTheFile) {
  std::string edited;
  {
    Document d(file);
    d.edit({value("6")});
    edited = d.text();
    EXPECT_EQ(beside(), edited);
  }  // as if the program had been killed
  Document d(file);
  EXPECT_EQ(d.text(), kDocumentText);
  EXPECT_EQ(d.recovered(), edited);
  d.recover(true);
  EXPECT_EQ(d.text(), edited);
  d.save(false);
  EXPECT_EQ(*read_file(file), edited);
  EXPECT_FALSE(fs::exists(file.parent_path() / ".graph.yaml.unsaved"));
  EXPECT_TRUE(d.undo());
  EXPECT_FALSE(d.saved());
  EXPECT_EQ(beside(), kDocumentText);
}

TEST_F(StudioDocument, AnEditBeforeTheQuestionIsAnsweredLosesNothing) {
  {
    Document d(file);
    d.edit({value("6")});
  }
  const std::string left = beside();
  Document d(file);
  d.edit({value("7")});
  EXPECT_EQ(beside(), left);
  EXPECT_EQ(read_file(second), d.text());  // kept too
  d.save(false);
  EXPECT_EQ(d.recovered(), left);  // saving something else is no answer
  EXPECT_EQ(beside(), left);
  EXPECT_FALSE(fs::exists(second));
  d.edit({value("8")});
  d.recover(false);
  EXPECT_EQ(beside(), "");
  EXPECT_EQ(read_file(second), d.text());
}

const std::string kPlaced = studio::arrangement_text({{"places", {{"a", {10, 20}}}}});

TEST_F(StudioDocument, PlacesAndNotesAreUndone) {
  const fs::path kept = studio::arrangement_file(file);
  const std::string moved = studio::arrangement_text({{"places", {{"a", {30, 20}}}}});
  Document d(file);
  const auto first = d.revision();
  d.arrange(kPlaced);
  d.arrange(moved);
  EXPECT_EQ(read_file(kept), moved);
  EXPECT_TRUE(d.saved());  // it is no part of the graph
  EXPECT_TRUE(d.undo());
  EXPECT_EQ(read_file(kept), kPlaced);
  EXPECT_TRUE(d.undo());
  EXPECT_FALSE(fs::exists(kept));
  EXPECT_FALSE(d.undo());
  EXPECT_TRUE(d.redo());
  EXPECT_EQ(d.arrangement(), kPlaced);
  EXPECT_EQ(d.revision(), first);
  d.arrange(studio::arrangement_text({{"places", {{"a", {10, 20}}}}, {"notes", json::array()}}));
  EXPECT_TRUE(d.can_redo());  // an empty list of notes is no change
  // Texts and places are undone in the order in which they changed.
  d.edit({value("6")});
  d.arrange(moved);
  EXPECT_TRUE(d.undo());
  EXPECT_NE(d.text(), kDocumentText);
  EXPECT_EQ(d.arrangement(), kPlaced);
  EXPECT_TRUE(d.undo());
  EXPECT_EQ(d.text(), kDocumentText);
  EXPECT_EQ(d.arrangement(), kPlaced);
}

TEST_F(StudioDocument, APlaceBelongsToTheEditThatMakesOrRenamesTheNode) {
  Document d(file);
  Edit add{Edit::Kind::AddNode, "b"};
  add.type = "Constant";
  d.edit({add}, {}, {{"b", {1, 2}}});
  Edit rename{Edit::Kind::RenameNode, "b"};
  rename.to = "c";
  d.edit({rename});
  EXPECT_EQ(d.arrangement(), studio::arrangement_text({{"places", {{"c", {1.0, 2.0}}}}}));
  EXPECT_TRUE(d.undo());
  EXPECT_EQ(d.arrangement(), studio::arrangement_text({{"places", {{"b", {1.0, 2.0}}}}}));
  EXPECT_TRUE(d.undo());
  EXPECT_EQ(d.text(), kDocumentText);
  EXPECT_EQ(d.arrangement(), "");
}

TEST_F(StudioDocument, AnArrangementThatAnotherProgramChangesComesBackWithUndo) {
  Document d(file);
  d.arrange(kPlaced);
  EXPECT_FALSE(d.follow_arrangement());
  const std::string theirs = studio::arrangement_text({{"places", {{"a", {5, 5}}}}});
  write_text_atomically(studio::arrangement_file(file), theirs);
  d.arrange("");  // before anybody looked at the file
  EXPECT_EQ(d.arrangement(), "");
  EXPECT_TRUE(d.undo());
  EXPECT_EQ(d.arrangement(), theirs);
  EXPECT_TRUE(d.undo());
  EXPECT_EQ(d.arrangement(), kPlaced);
}

TEST_F(StudioDocument, AnArrangementFollowsTheGraphToAnotherName) {
  Document d(file, true);
  d.arrange(kPlaced);
  EXPECT_FALSE(fs::exists(studio::arrangement_file(file)));  // nothing is written beside what is read only
  const fs::path mine = file.parent_path() / "mine.yaml";
  d.save_as(mine, d.text());
  EXPECT_EQ(read_file(studio::arrangement_file(mine)), kPlaced);
}

// Folders in the places of files refuse every write, as a full disk does.
TEST_F(StudioDocument, WhatCannotBeWrittenIsReportedAndStaysInMemory) {
  const auto block = [](const fs::path& p) { fs::create_directories(p / "full"); };
  Document d(file);
  const fs::path elsewhere = test::temporary_folder() / "away";
  fs::rename(file.parent_path(), elsewhere);
  d.edit({value("6")});
  fs::rename(elsewhere, file.parent_path());
  EXPECT_NE(d.text().find("value: 6"), std::string::npos);
  EXPECT_NE(d.trouble().find("unsaved changes cannot be kept"), std::string::npos) << d.trouble();
  fs::remove(file);
  block(file);
  EXPECT_EQ(test::code_of([&] { d.save(true); }), "write-failed");
  EXPECT_FALSE(d.saved());
  fs::remove_all(file);
  d.save(true);
  EXPECT_EQ(*read_file(file), d.text());
  EXPECT_EQ(d.trouble(), "");
  d.arrange(kPlaced);
  const fs::path kept = studio::arrangement_file(file);
  fs::remove(kept);
  block(kept);
  EXPECT_EQ(test::code_of([&] { d.arrange(""); }), "file-exists");
  EXPECT_EQ(d.arrangement(), kPlaced);
  EXPECT_TRUE(d.undo());
  EXPECT_NE(d.trouble().find("places and notes cannot be kept"), std::string::npos) << d.trouble();
}

TEST_F(StudioDocument, AFileThatChangedOnDiskIsNotOverwritten) {
  Document d(file);
  d.edit({value("6")});
  write_text_atomically(file, kDocumentText + "# by another program\n");
  EXPECT_TRUE(d.changed_on_disk());
  EXPECT_EQ(test::code_of([&] { d.save(false); }), "file-changed");
  EXPECT_EQ(*read_file(file), kDocumentText + "# by another program\n");
  const std::string mine = d.text();
  d.reload();
  EXPECT_EQ(d.text(), kDocumentText + "# by another program\n");
  EXPECT_TRUE(d.undo());
  EXPECT_EQ(d.text(), mine);
  d.save(true);
  EXPECT_EQ(*read_file(file), mine);
}

TEST_F(StudioDocument, SavingThroughLinksReplacesWhatTheyReferTo) {
  const fs::path shelf = test::temporary_folder(), link = shelf / "link.yaml";
  fs::permissions(file, fs::perms::owner_read | fs::perms::owner_write);
  fs::create_symlink(file, shelf / "other.yaml");
  fs::create_symlink("other.yaml", link);
  Document d(link);
  d.edit({value("6")});
  d.save(false);
  EXPECT_EQ(*read_file(file), d.text());
  EXPECT_EQ(fs::read_symlink(link), "other.yaml");
  EXPECT_EQ(fs::read_symlink(shelf / "other.yaml"), file);
  EXPECT_EQ(fs::status(file).permissions(), fs::perms::owner_read | fs::perms::owner_write);
  EXPECT_EQ(std::distance(fs::directory_iterator(shelf), {}), 2);  // nothing else is left beside the link
  // Another program's change of the target counts.
  write_text_atomically(file, kDocumentText);
  d.edit({value("7")});
  EXPECT_EQ(test::code_of([&] { d.save(false); }), "file-changed");
  // A write that fails leaves link and target as they were; a target that is gone is made again.
  fs::remove(file);
  fs::create_directories(file / "full");
  EXPECT_EQ(test::code_of([&] { d.save(true); }), "write-failed");
  EXPECT_TRUE(fs::is_symlink(link));
  EXPECT_TRUE(fs::exists(file / "full"));
  fs::remove_all(file);
  d.save(true);
  EXPECT_EQ(*read_file(file), d.text());
  EXPECT_TRUE(fs::is_symlink(link));
  // Links that refer to each other lead nowhere.
  fs::remove(shelf / "other.yaml");
  fs::create_symlink("link.yaml", shelf / "other.yaml");
  EXPECT_EQ(test::code_of([&] { d.save(true); }), "write-failed");
  EXPECT_TRUE(fs::is_symlink(link));
}

TEST_F(StudioDocument, BadTextAndBadFilesAreRefused) {
  Document d(file);
  EXPECT_EQ(test::code_of([&] { d.replace("\xff"); }), "not-utf8");
  EXPECT_EQ(test::code_of([&] { d.replace(std::string(kMaxGraphBytes + 1, ' ')); }), "too-large");
  EXPECT_EQ(d.text(), kDocumentText);
  EXPECT_EQ(test::code_of([&] { Document(file.parent_path() / "none.yaml"); }), "no-file");
  Document given(file, true);
  given.edit({value("6")});
  EXPECT_EQ(beside(), "");
  EXPECT_EQ(test::code_of([&] { given.save(false); }), "read-only");
}

}  // namespace
}  // namespace terrazzo
