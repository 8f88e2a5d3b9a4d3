// Tests modbus_master on virtual time. The server of libmodbus, on a thread of the test, plays the device.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>

#include <arpa/inet.h>
#include <modbus/modbus.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <takt/testing.hpp>

#include <basic.hpp>

#include "../common/basic_values.hpp"
#include "../common/beside_threads.hpp"

namespace {

using namespace std::chrono_literals;
using common::flag;
using common::number;
using takt::lifecycle::State;
using takt::testing::Module;

/// A device that serves one master at a time, on a free port of the loopback interface.
class Device {
 public:
  Device() {
    const int listener = modbus_tcp_listen(context_.get(), 1);
    sockaddr_in address{};
    socklen_t size = sizeof address;
    if (listener < 0 || ::getsockname(listener, reinterpret_cast<sockaddr*>(&address), &size) != 0)
      throw std::runtime_error("found no free TCP port");
    port_ = ntohs(address.sin_port);
    thread_ = std::thread{[this, listener] { work(listener); }};
  }
  ~Device() {
    end_ = true;
    thread_.join();
  }
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  [[nodiscard]] int port() const { return port_; }
  /// From now on, the device knows only the functions that write a single coil or register.
  void write_only_singly() { only_single_ = true; }
  /// Calls `use` with the device's tables while the device answers no request.
  template <class Use>
  auto with_tables(Use&& use) {
    const std::lock_guard lock{mutex_};
    return use(*tables_);
  }

 private:
  void work(int listener) {
    int client = -1;
    while (!end_) {
      pollfd waiting{.fd = client < 0 ? listener : client, .events = POLLIN, .revents = 0};
      if (::poll(&waiting, 1, 5) <= 0) continue;
      if (client < 0) {
        client = modbus_tcp_accept(context_.get(), &listener);
        continue;
      }
      std::uint8_t request[MODBUS_TCP_MAX_ADU_LENGTH];
      const int length = modbus_receive(context_.get(), request);
      const std::lock_guard lock{mutex_};
      const bool multiple =
          request[7] == MODBUS_FC_WRITE_MULTIPLE_COILS || request[7] == MODBUS_FC_WRITE_MULTIPLE_REGISTERS;
      if (length > 0 && only_single_ && multiple) {
        modbus_reply_exception(context_.get(), request, MODBUS_EXCEPTION_ILLEGAL_FUNCTION);
        continue;
      }
      if (length > 0 && modbus_reply(context_.get(), request, length, tables_.get()) >= 0) continue;
      modbus_close(context_.get());
      client = -1;
    }
    modbus_close(context_.get());
    ::close(listener);
  }

  std::unique_ptr<modbus_t, void (*)(modbus_t*)> context_{modbus_new_tcp("127.0.0.1", 0), modbus_free};
  std::unique_ptr<modbus_mapping_t, void (*)(modbus_mapping_t*)> tables_{modbus_mapping_new(16, 16, 16, 16),
                                                                         modbus_mapping_free};
  int port_ = 0;
  std::atomic<bool> only_single_{false};
  std::mutex mutex_;
  std::atomic<bool> end_{false};
  std::thread thread_;
};

constexpr const char* kMap = R"(
  lamp        out coil 0 safe 0
  speed       out register 10 scale 0.001 unit m/s safe 0
  button      in  discrete 3
  temperature in  input-register 4 int16 scale 0.1 unit degC
)";

class ModbusMaster : public ::testing::Test {
 protected:
  ModbusMaster() { prepare(device ? device->port() : 0); }
  void prepare(int port) {
    EXPECT_TRUE(module.set("map", kMap));
    EXPECT_TRUE(module.set("port", std::to_string(port)));
    EXPECT_TRUE(module.set("cycle", "0.002"));
  }
  template <class Done>
  bool comes(Done&& done) {
    return common::comes_in_time(module, done);
  }
  bool lamp_is(bool lit) {
    return device->with_tables([&](modbus_mapping_t& tables) { return (tables.tab_bits[0] != 0) == lit; });
  }
  int speed() {
    return device->with_tables([](modbus_mapping_t& tables) { return int{tables.tab_registers[10]}; });
  }

  std::unique_ptr<Device> device = std::make_unique<Device>();
  Module module{{.period = 10ms}};
};

TEST_F(ModbusMaster, ExchangesValuesInBothDirections) {
  device->with_tables([](modbus_mapping_t& tables) {
    tables.tab_input_bits[3] = 1;
    tables.tab_input_registers[4] = static_cast<std::uint16_t>(-215);
  });
  ASSERT_TRUE(module.initialize());
  auto& lamp = module.in<basic::Flag>("lamp");
  auto& speed_wanted = module.in<basic::Number>("speed");
  auto& button = module.out<basic::Flag>("button");
  auto& temperature = module.out<basic::Number>("temperature");
  auto& connected = module.out<basic::Flag>("connected");
  ASSERT_TRUE(module.start());
  lamp.write(flag(true));
  speed_wanted.write(number(1.25));
  ASSERT_TRUE(comes([&] { return temperature.has_value() && lamp_is(true) && speed() == 1250; }));
  EXPECT_TRUE(button.value().value());
  EXPECT_NEAR(temperature.value().value(), -21.5, 1e-9);
  EXPECT_TRUE(comes([&] { return connected.value().value(); }));

  device->with_tables([](modbus_mapping_t& tables) { tables.tab_input_bits[3] = 0; });
  lamp.write(flag(false));
  EXPECT_TRUE(comes([&] { return !button.value().value() && lamp_is(false); }));
}

TEST_F(ModbusMaster, WritesSafeValuesWhenItEnds) {
  ASSERT_TRUE(module.initialize());
  auto& lamp = module.in<basic::Flag>("lamp");
  auto& speed_wanted = module.in<basic::Number>("speed");
  ASSERT_TRUE(module.start());
  lamp.write(flag(true));
  speed_wanted.write(number(1));
  ASSERT_TRUE(comes([&] { return lamp_is(true) && speed() == 1000; }));
  ASSERT_TRUE(module.destruct());
  EXPECT_TRUE(lamp_is(false));
  EXPECT_EQ(speed(), 0);
}

TEST_F(ModbusMaster, WritesSinglyIfTheDeviceKnowsNoOtherWayToWrite) {
  device->write_only_singly();
  ASSERT_TRUE(module.set("map",
                         "lamp out coil 0 safe 0; horn out coil 1 safe 1\n"
                         "speed out register 10 safe 3; place out register 11 uint32 safe 65540"));
  ASSERT_TRUE(module.initialize());
  auto& lamp = module.in<basic::Flag>("lamp");
  auto& horn = module.in<basic::Flag>("horn");
  auto& speed_wanted = module.in<basic::Number>("speed");
  auto& place = module.in<basic::Number>("place");
  auto& connected = module.out<basic::Flag>("connected");
  ASSERT_TRUE(module.start());
  lamp.write(flag(true));
  horn.write(flag(false));
  speed_wanted.write(number(7));
  place.write(number(131080));
  const auto device_has = [&](int lamp_bit, int horn_bit, int speed_register, int high, int low) {
    return device->with_tables([&](modbus_mapping_t& tables) {
      return tables.tab_bits[0] == lamp_bit && tables.tab_bits[1] == horn_bit &&
             tables.tab_registers[10] == speed_register && tables.tab_registers[11] == high &&
             tables.tab_registers[12] == low;
    });
  };
  ASSERT_TRUE(comes([&] { return device_has(1, 0, 7, 2, 8); }));
  EXPECT_TRUE(comes([&] { return connected.value().value(); })) << "this is no fault";
  ASSERT_TRUE(module.destruct());
  EXPECT_TRUE(device_has(0, 1, 3, 1, 4)) << "the device has not got its safe values";
}

TEST_F(ModbusMaster, PublishesNoValuesWhileTheDeviceIsGone) {
  ASSERT_TRUE(module.initialize());
  auto& button = module.out<basic::Flag>("button");
  auto& connected = module.out<basic::Flag>("connected");
  auto& failures = module.out<basic::Count>("failures");
  ASSERT_TRUE(module.start());
  ASSERT_TRUE(comes([&] { return connected.has_value() && connected.value().value(); }));
  device.reset();
  ASSERT_TRUE(comes([&] { return !connected.value().value() && failures.value().value() > 0; }));
  const std::uint64_t writes_before = button.count();
  EXPECT_EQ(module.step(1000), 1000U) << "the body waited for the network";
  EXPECT_EQ(button.count(), writes_before);
  EXPECT_TRUE(module.healthy());
}

TEST_F(ModbusMaster, CreatesItsPortsFromTheMap) {
  ASSERT_TRUE(module.set("map", "valve out coil 1"));
  ASSERT_TRUE(module.initialize());
  EXPECT_NO_THROW(module.in<basic::Flag>("valve"));
  EXPECT_THROW(module.in<basic::Flag>("lamp"), takt::testing::Error);
}

TEST_F(ModbusMaster, RejectsInvalidProperties) {
  const auto start_error = [this] {
    testing::internal::CaptureStderr();
    const takt::testing::Answer answer = module.start();
    EXPECT_FALSE(answer);
    return testing::internal::GetCapturedStderr() + answer.text();
  };
  ASSERT_TRUE(module.set("map", "lamp out coil 0\nhorn out spool 1"));
  EXPECT_THAT(start_error(), testing::HasSubstr("property 'map', line 2: "));
  ASSERT_TRUE(module.set("map", kMap));
  ASSERT_TRUE(module.set("host", ""));
  EXPECT_THAT(start_error(), testing::HasSubstr("property 'host' is empty"));
  ASSERT_TRUE(module.set("host", "127.0.0.1"));
  ASSERT_TRUE(module.set("port", "0"));
  EXPECT_THAT(start_error(), testing::HasSubstr("property 'port' cannot be '0'; it takes "));
}

}  // namespace
