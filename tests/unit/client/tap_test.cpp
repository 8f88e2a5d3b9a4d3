#include <takt/client/tap.hpp>

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include <takt/model/json.hpp>

namespace takt::client::tap_test {
namespace {

using testing::HasSubstr;

const std::string kType =
    R"({"name": "samples::Count", "fields": [{"name": "number", "type": "unsigned long"}]})";

TEST(FlowIn, ReadsTheTopicAndTypeOfAnAnswer) {
  const nlohmann::ordered_json answer{{"topic", "a/b"}, {"type", kType}, {"reliable", true}};
  const auto flow = flow_in(model::json_text(answer), "d.m.p");
  ASSERT_TRUE(flow.ok()) << to_text(flow.problems());
  EXPECT_EQ(flow->topic, "a/b");
  EXPECT_EQ(flow->type.name, "samples::Count");
  EXPECT_TRUE(flow->quality.reliable);
}

TEST(FlowIn, RejectsAnyOtherAnswer) {
  for (const char* data : {"", "no JSON", "5", "[]", "{}", R"({"topic": "a"})", R"({"topic": 5, "type": 5})",
                           R"({"topic": "a", "type": {}, "reliable": "yes"})"}) {
    const auto flow = flow_in(data, "d.m.p");
    ASSERT_FALSE(flow.ok()) << data;
    EXPECT_THAT(to_text(flow.problems()), HasSubstr("device d: error: its answer cannot be read")) << data;
  }
  const auto service = flow_in(R"({"topic": 5, "reply": 5})", "d.m.s");
  ASSERT_FALSE(service.ok());
  EXPECT_THAT(to_text(service.problems()), HasSubstr("takt call d.m.s"));
}

const PortName kCounted{"d", "m", "count"};

TEST(ServiceIn, ReadsTheTopicsAndTypesOfAnAnswer) {
  nlohmann::ordered_json answer{{"topic", "a/request"}, {"type", kType}, {"reliable", true}};
  const auto port = service_in(model::json_text(answer), kCounted);
  ASSERT_TRUE(port.ok());
  EXPECT_FALSE(*port) << "a port";
  answer["reply"] = {{"topic", "a/reply"}, {"type", kType}};
  const auto service = service_in(model::json_text(answer), kCounted);
  ASSERT_TRUE(service.ok() && *service);
  EXPECT_EQ((*service)->request_topic, "a/request");
  EXPECT_EQ((*service)->reply_topic, "a/reply");
  EXPECT_EQ((*service)->reply.name, "samples::Count");
}

TEST(ServiceIn, RejectsAnyOtherAnswer) {
  for (const nlohmann::ordered_json& reply : {nlohmann::ordered_json(5), nlohmann::ordered_json::object(),
                                              nlohmann::ordered_json{{"topic", 5}, {"type", kType}},
                                              nlohmann::ordered_json{{"topic", "a"}, {"type", "no type"}}}) {
    const nlohmann::ordered_json answer{{"topic", "a"}, {"type", kType}, {"reply", reply}};
    const auto service = service_in(model::json_text(answer), kCounted);
    ASSERT_FALSE(service.ok()) << answer;
    EXPECT_THAT(to_text(service.problems()), HasSubstr("device d: error: its answer cannot be read"));
  }
}

model::Port port(const char* name, model::Direction direction, model::Role role = model::Role::plain) {
  return {.name = name, .direction = direction, .type = {}, .text = {}, .role = role};
}

TEST(NotAService, SaysWhatTheNameIsAndListsTheServicesOfTheModule) {
  using enum model::Direction;
  const std::vector<model::Port> ports{port("state", out),
                                       port("target", in),
                                       port("news", event),
                                       port("count/request", in, model::Role::handler),
                                       port("count/reply", out, model::Role::handler),
                                       port("ask/request", out, model::Role::client),
                                       port("ask/reply", in, model::Role::client)};
  const auto text = [&](const char* name) {
    const auto problem = not_a_service({"d", "m", name}, ports);
    return problem ? to_text(*problem) : "";
  };
  EXPECT_EQ(text("count"), "");
  EXPECT_EQ(text("ask"), "") << "the device explains what a client is";
  EXPECT_EQ(text("state"),
            "error: d.m.state is an output port, not a service; show its samples with takt echo d.m.state; "
            "services of the module: d.m.count");
  EXPECT_EQ(text("target"),
            "error: d.m.target is an input port, not a service; services of the module: d.m.count");
  EXPECT_THAT(text("news"), HasSubstr("d.m.news is an input port"));
  EXPECT_EQ(text("coumt"), "error: module d.m has no service 'coumt'; did you mean d.m.count?");
  EXPECT_EQ(to_text(*not_a_service({"d", "m", "x"}, {port("state", out)})),
            "error: module d.m has no service 'x'; no module of device d has one");
}

TEST(NotAService, ListsTheServicesThatExist) {
  using enum model::Direction;
  const std::set<std::string> others{"d.a.count", "d.b.weigh"};
  const std::vector<model::Port> count{port("count/request", in, model::Role::handler)};
  EXPECT_EQ(to_text(*not_a_service({"d", "m", ""}, count, others)),
            "error: d.m is a module, not a service; services of the module: d.m.count");
  EXPECT_EQ(to_text(*not_a_service({"d", "m", ""}, {}, others)),
            "error: module d.m has no services; services of other modules: d.a.count or d.b.weigh");
  EXPECT_EQ(to_text(*not_a_service({"d", "m", "x"}, {port("state", out)}, others)),
            "error: module d.m has no service 'x'; services of other modules: d.a.count or d.b.weigh");
}

}  // namespace
}  // namespace takt::client::tap_test
