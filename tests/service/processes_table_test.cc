#include <gtest/gtest.h>

#include <set>

#include "src/service/processes/helps.h"
#include "src/service/processes/job_work.h"
#include "src/service/processes/kinds.h"
#include "src/service/processes/table.h"

namespace tessera::service {
namespace {

// A process without a row would be accepted by the message and never done.
TEST(ProcessesTable, HasARowForEachKindOfInputs) {
  std::set<std::string> wanted, rows;
  const auto& kinds = *proto::Inputs::descriptor()->oneof_decl(0);
  for (int i = 0; i < kinds.field_count(); ++i) wanted.insert(kinds.field(i)->name());
  for (const Process* process : all_processes()) {
    rows.insert(process->name);
    EXPECT_NE(process->run, nullptr) << process->name;
    EXPECT_EQ(process->estimated(), process->estimate != nullptr) << process->name;
    EXPECT_EQ(&member_of(*process), kinds.file()->FindMessageTypeByName("Inputs")->FindFieldByName(process->name));
    EXPECT_EQ(find_process(process->name), process);
  }
  EXPECT_EQ(rows, wanted);
  EXPECT_EQ(find_process("nothing"), nullptr);
}

TEST(ProcessesTable, SaysOfEachInputWhatItMeans) {
  for (const Process* process : all_processes()) {
    const auto& inputs = *member_of(*process).message_type();
    for (int i = 0; i < inputs.field_count(); ++i)
      EXPECT_NE(help_of(inputs.field(i)->name()), nullptr) << process->name << ", " << inputs.field(i)->name();
    // Who reads a result has a field for its name.
    EXPECT_EQ(process->reads != Process::Reads::no_result, inputs.FindFieldByName("triangulation") != nullptr)
        << process->name;
  }
  EXPECT_EQ(help_of("nothing"), nullptr);
}

TEST(ProcessesTable, TellsWhatInputsReadAndMake) {
  proto::Inputs inputs;
  EXPECT_EQ(process_of(inputs), "");
  EXPECT_EQ(result_read(inputs), "");
  EXPECT_FALSE(makes_result(inputs));
  EXPECT_FALSE(overwrites(inputs));
  inputs.mutable_triangulate()->set_output("block");
  inputs.mutable_triangulate()->set_overwrite(true);
  EXPECT_EQ(process_of(inputs), "triangulate");
  EXPECT_TRUE(makes_result(inputs) && overwrites(inputs));
  EXPECT_EQ(result_output(inputs), "block");
  EXPECT_EQ(export_output(inputs), std::nullopt);
  EXPECT_EQ(result_read(inputs), "");
  inputs.mutable_dem()->set_triangulation("block");
  EXPECT_EQ(export_output(inputs), "dem.tif");
  EXPECT_EQ(result_read(inputs), "block");
  EXPECT_FALSE(makes_result(inputs) || overwrites(inputs));
  inputs.mutable_surface()->set_format("3dtiles");
  EXPECT_NE(export_output(inputs), "surface.ply");
  inputs.mutable_surface()->set_format("ply");
  EXPECT_EQ(export_output(inputs), "surface.ply");
  inputs.mutable_export_()->set_output("a.vtu");
  EXPECT_EQ(export_output(inputs), "a.vtu");
  EXPECT_FALSE(changes_result(inputs));
  inputs.mutable_hag()->set_triangulation("ground");
  EXPECT_EQ(export_output(inputs), "heights");
  EXPECT_EQ(result_read(inputs), "ground");
  inputs.mutable_measure()->set_triangulation("block");
  EXPECT_EQ(export_output(inputs), std::nullopt);
  EXPECT_EQ(result_read(inputs), "block");
  EXPECT_TRUE(changes_result(inputs));
  EXPECT_FALSE(makes_result(inputs));
  EXPECT_EQ(second_result_read(inputs), "");
  inputs.mutable_volume()->set_triangulation("before");
  inputs.mutable_volume()->set_second("after");
  inputs.mutable_volume()->set_output("volumes.csv");
  EXPECT_EQ(result_read(inputs), "before");
  EXPECT_EQ(second_result_read(inputs), "after");
  EXPECT_EQ(export_output(inputs), "volumes.csv");
  auto& update = *inputs.mutable_update();
  update.set_triangulation("block");
  EXPECT_TRUE(changes_result(inputs));
  EXPECT_FALSE(makes_result(inputs));
  EXPECT_EQ(second_result_read(inputs), "");
  update.set_output("next");
  EXPECT_FALSE(changes_result(inputs));
  EXPECT_TRUE(makes_result(inputs));
  EXPECT_EQ(result_output(inputs), "next");
  EXPECT_EQ(second_result_read(inputs), "block");
  update.set_dry_run(true);
  EXPECT_FALSE(changes_result(inputs) || makes_result(inputs));
  EXPECT_EQ(export_output(inputs), std::nullopt);
  for (const char* name : {"alpha", "density", "voronoi"})
    EXPECT_EQ(find_process(name)->makes, Process::Makes::file) << name;
}

}  // namespace
}  // namespace tessera::service
