/* A program that uses Cyclone DDS. Cyclone's own IDL compiler generates its types from Takt's IDL. This program uses nothing else of Takt.
 *
 *   cyclone_peer DOMAIN watch SECONDS                               prints what nodes publish, one JSON object a line
 *   cyclone_peer DOMAIN command DEVICE MODULE KIND [PROPERTY VALUE] KIND as a number of takt::CommandKind; prints the answer
 *   cyclone_peer DOMAIN write TYPE TOPIC COUNT PERIOD_MS RELIABILITY
 *   cyclone_peer DOMAIN read TYPE TOPIC COUNT SECONDS RELIABILITY   until COUNT samples have arrived
 *
 * TYPE: Sample, Mixed, BeltCommand, BeltState, Part. RELIABILITY: reliable, best-effort. "-" stands for no module. */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "dds/dds.h"
#include "line.h"
#include "port.h"
#include "takt.h"

static int64_t wall_ns(void) {
  struct timespec t;
  clock_gettime(CLOCK_REALTIME, &t);
  return (int64_t)t.tv_sec * 1000000000 + t.tv_nsec;
}

static dds_entity_t must(dds_entity_t entity, const char *what) {
  if (entity >= 0) return entity;
  fprintf(stderr, "%s: %s\n", what, dds_strretcode(-entity));
  exit(3);
}

static dds_qos_t *state(void) {
  dds_qos_t *qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
  dds_qset_durability(qos, DDS_DURABILITY_TRANSIENT_LOCAL);
  dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 64);
  dds_qset_liveliness(qos, DDS_LIVELINESS_MANUAL_BY_TOPIC, DDS_MSECS(300));
  return qos;
}

static dds_qos_t *quality(const char *reliability) {
  dds_qos_t *qos = dds_create_qos();
  dds_qset_reliability(qos, strcmp(reliability, "reliable") == 0 ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT,
                       DDS_SECS(1));
  dds_qset_durability(qos, DDS_DURABILITY_VOLATILE);
  dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 32);
  return qos;
}

static void print_text(const char *name, const char *text) {
  printf(", \"%s\": \"", name);
  for (; *text; ++text) {
    if (*text == '"' || *text == '\\') {
      printf("\\%c", *text);
    } else if ((unsigned char)*text < 0x20) {
      printf("\\u%04x", (unsigned)*text);
    } else {
      putchar(*text);
    }
  }
  putchar('"');
}

/* ---- watch */

static void print_lifecycle(const void *sample) {
  const takt_LifecycleStatus *s = sample;
  printf("{\"topic\": \"lifecycle\"");
  print_text("path", s->path);
  print_text("cell", s->cell);
  print_text("device", s->device);
  print_text("name", s->name);
  print_text("text", s->text);
  printf(", \"state\": %d, \"previous_state\": %d, \"event\": %d, \"error\": %d, \"sequence_number\": %" PRIu64
         ", \"time_ns\": %" PRId64 "}\n",
         (int)s->state, (int)s->previous_state, (int)s->event, (int)s->error, s->sequence_number, s->time_ns);
}

static void print_device(const void *sample) {
  const takt_DeviceStatus *s = sample;
  printf("{\"topic\": \"device\"");
  print_text("path", s->path);
  print_text("cell", s->cell);
  print_text("device", s->device);
  print_text("node", s->node);
  print_text("host_name", s->host_name);
  print_text("text", s->text);
  print_text("deployment", s->deployment);
  printf(", \"state\": %d, \"health\": %d, \"real_time\": %s, \"process_id\": %d, \"host_process_id\": %d, \"modules\": %u"
         ", \"executing\": %u, \"sequence_number\": %" PRIu64 "}\n",
         (int)s->state, (int)s->health, s->real_time ? "true" : "false", s->process_id, s->host_process_id, s->modules,
         s->executing, s->sequence_number);
}

static void print_statistics(const void *sample) {
  const takt_ModuleStatistics *s = sample;
  printf("{\"topic\": \"statistics\"");
  print_text("path", s->path);
  print_text("name", s->name);
  printf(", \"cycles\": %" PRIu64 ", \"overruns\": %" PRIu64 ", \"jitter_mean_us\": %g, \"run_p99_us\": %g}\n", s->cycles,
         s->overruns, s->jitter_us.mean, s->run_us.p99);
}

struct watched {
  const char *name;
  const dds_topic_descriptor_t *type;
  int is_state;
  void (*print)(const void *);
  dds_entity_t reader;
  uint32_t not_alive;
};

static int watch(dds_entity_t participant, double seconds) {
  struct watched all[] = {{"takt/lifecycle", &takt_LifecycleStatus_desc, 1, print_lifecycle, 0, 0},
                          {"takt/device", &takt_DeviceStatus_desc, 1, print_device, 0, 0},
                          {"takt/statistics", &takt_ModuleStatistics_desc, 0, print_statistics, 0, 0}};
  for (int i = 0; i < 3; ++i) {
    dds_qos_t *qos = all[i].is_state ? state() : quality("best-effort");
    const dds_entity_t topic = must(dds_create_topic(participant, all[i].type, all[i].name, NULL, NULL), all[i].name);
    all[i].reader = must(dds_create_reader(participant, topic, qos, NULL), all[i].name);
    dds_delete_qos(qos);
  }
  const int64_t end = wall_ns() + (int64_t)(seconds * 1e9);
  while (wall_ns() < end) {
    for (int i = 0; i < 3; ++i) {
      void *samples[16] = {NULL};
      dds_sample_info_t info[16];
      const int count = dds_take(all[i].reader, samples, info, 16, 16);
      for (int k = 0; k < count; ++k) {
        if (info[k].valid_data) all[i].print(samples[k]);
        if (info[k].instance_state == DDS_IST_NOT_ALIVE_DISPOSED) {
          printf("{\"topic\": \"%s\"", all[i].name + 5);
          print_text("disposed", samples[k]); /* path is the first member of each type */
          printf("}\n");
        }
      }
      if (count > 0) dds_return_loan(all[i].reader, samples, count);
      dds_liveliness_changed_status_t liveliness;
      if (dds_get_liveliness_changed_status(all[i].reader, &liveliness) == 0 && liveliness.not_alive_count != all[i].not_alive) {
        all[i].not_alive = liveliness.not_alive_count;
        printf("{\"topic\": \"%s\", \"not_alive\": %u}\n", all[i].name + 5, liveliness.not_alive_count);
      }
    }
    fflush(stdout);
    usleep(10000);
  }
  return 0;
}

/* ---- command */

static int ask(dds_entity_t participant, int count, char **words) {
  dds_qos_t *qos = quality("reliable");
  const dds_entity_t writer = must(
      dds_create_writer(participant, must(dds_create_topic(participant, &takt_Command_desc, "takt/command", NULL, NULL), "topic"), qos, NULL),
      "writer");
  const dds_entity_t reader =
      must(dds_create_reader(participant, must(dds_create_topic(participant, &takt_Reply_desc, "takt/reply", NULL, NULL), "topic"), qos, NULL),
           "reader");
  takt_Command command;
  memset(&command, 0, sizeof command);
  snprintf(command.id, sizeof command.id, "cyclone-%d-%" PRId64, (int)getpid(), wall_ns());
  snprintf(command.device, sizeof command.device, "%s", words[0]);
  if (strcmp(words[1], "-") != 0) snprintf(command.module_name, sizeof command.module_name, "%s", words[1]);
  command.kind = (takt_CommandKind)atoi(words[2]);
  if (count > 3) snprintf(command.property, sizeof command.property, "%s", words[3]);
  if (count > 4) snprintf(command.value, sizeof command.value, "%s", words[4]);
  command.deadline_ns = wall_ns() + INT64_C(10000000000);
  command.parts = 1;
  /* A command sent before writer and reader have matched is lost, so this loop repeats it with the same id. */
  for (int attempt = 0; attempt < 100; ++attempt) {
    if (attempt % 10 == 0) dds_write(writer, &command);
    usleep(100000);
    void *samples[8] = {NULL};
    dds_sample_info_t info[8];
    const int taken = dds_take(reader, samples, info, 8, 8);
    int found = 0;
    for (int i = 0; i < taken && !found; ++i) {
      const takt_Reply *reply = samples[i];
      if (!info[i].valid_data || strcmp(reply->id, command.id) != 0) continue;
      printf("{\"code\": %d, \"state\": %d, \"parts\": %u, \"bytes\": %u", (int)reply->code, (int)reply->state, reply->parts,
             reply->data._length);
      print_text("device", reply->device);
      print_text("node", reply->node);
      print_text("text", reply->text);
      print_text("value", reply->value);
      printf("}\n");
      found = 1;
    }
    if (taken > 0) dds_return_loan(reader, samples, taken);
    if (found) return 0;
  }
  fprintf(stderr, "no answer\n");
  return 1;
}

/* ---- ports */

static void print_sample(const void *sample) {
  const test_Sample *s = sample;
  unsigned whole = 1;
  for (uint32_t i = 0; i < s->data._length; ++i) whole &= s->data._buffer[i] == (uint8_t)(s->number + i);
  printf("{\"number\": %" PRIu64 ", \"value\": %" PRId64 ", \"data\": %u, \"whole\": %s}\n", s->number, s->value, s->data._length,
         whole ? "true" : "false");
}

static void fill_sample(void *sample, unsigned number) {
  test_Sample *s = sample;
  static uint8_t bytes[65536];
  s->number = number;
  s->value = -(int64_t)number;
  s->data._buffer = bytes;
  s->data._length = s->data._maximum = number * 7919 % 65537;
  for (uint32_t i = 0; i < s->data._length; ++i) bytes[i] = (uint8_t)(number + i);
}

static void print_mixed(const void *sample) {
  const test_Mixed *s = sample;
  printf("{\"flag\": %s, \"small\": %u, \"number\": %d, \"colour\": %d", s->flag ? "true" : "false", s->small, s->number,
         (int)s->colour);
  print_text("name", s->name);
  printf(", \"places\": [[%g, %g], [%g, %g]], \"values\": [", s->places[0].x, s->places[0].angle, s->places[1].x, s->places[1].angle);
  for (uint32_t i = 0; i < s->values._length; ++i) printf("%s%g", i ? ", " : "", s->values._buffer[i]);
  printf("], \"way\": [");
  for (uint32_t i = 0; i < s->way._length; ++i) printf("%s[%g, %g]", i ? ", " : "", s->way._buffer[i].x, s->way._buffer[i].angle);
  printf("], \"last\": %" PRId64 "}\n", s->last);
}

static void fill_mixed(void *sample, unsigned number) {
  test_Mixed *s = sample;
  static double values[4];
  static test_Place way[3];
  s->flag = number % 2;
  s->small = (uint8_t)number;
  s->number = (int16_t) - (int)number;
  s->colour = (test_Colour)(number % 3);
  snprintf(s->name, sizeof s->name, "%.*s", (int)(number % 16), "abcdefghijklmno");
  for (int i = 0; i < 2; ++i) s->places[i] = (test_Place){number + i, 0.5f * (float)i};
  s->values._buffer = values;
  s->values._length = s->values._maximum = number % 5;
  for (uint32_t i = 0; i < s->values._length; ++i) values[i] = number * 10 + i;
  s->way._buffer = way;
  s->way._length = s->way._maximum = number % 4;
  for (uint32_t i = 0; i < s->way._length; ++i) way[i] = (test_Place){i, 0.25f};
  s->last = INT64_C(1) << 40;
}

static void print_belt_command(const void *sample) { printf("{\"speed\": %g}\n", ((const line_BeltCommand *)sample)->speed); }
static void fill_belt_command(void *sample, unsigned number) { ((line_BeltCommand *)sample)->speed = 0.01 * number; }

static void print_belt_state(const void *sample) {
  const line_BeltState *s = sample;
  printf("{\"mode\": %d, \"speed\": %g, \"position\": %g, \"parts\": %u}\n", (int)s->mode, s->speed, s->position, s->parts);
}
static void fill_belt_state(void *sample, unsigned number) {
  *(line_BeltState *)sample = (line_BeltState){.mode = line_BELT_RUNNING, .speed = 0.1, .position = 0.001 * number, .parts = number};
}

static void print_part(const void *sample) {
  const line_Part *s = sample;
  printf("{\"number\": %u, \"y\": %g", s->number, s->y);
  print_text("kind", s->kind);
  printf("}\n");
}
static void fill_part(void *sample, unsigned number) {
  line_Part *s = sample;
  s->number = number;
  s->y = 0.01;
  snprintf(s->kind, sizeof s->kind, "box");
}

static const struct port_type {
  const char *name;
  const dds_topic_descriptor_t *type;
  void (*print)(const void *);
  void (*fill)(void *, unsigned);
} kTypes[] = {{"Sample", &test_Sample_desc, print_sample, fill_sample},
              {"Mixed", &test_Mixed_desc, print_mixed, fill_mixed},
              {"BeltCommand", &line_BeltCommand_desc, print_belt_command, fill_belt_command},
              {"BeltState", &line_BeltState_desc, print_belt_state, fill_belt_state},
              {"Part", &line_Part_desc, print_part, fill_part}};

static const struct port_type *type_of(const char *name) {
  for (size_t i = 0; i < sizeof kTypes / sizeof *kTypes; ++i) {
    if (strcmp(name, kTypes[i].name) == 0) return &kTypes[i];
  }
  fprintf(stderr, "there is no type %s\n", name);
  exit(2);
}

static int write_port(dds_entity_t participant, char **words) {
  const struct port_type *type = type_of(words[0]);
  dds_qos_t *qos = quality(words[4]);
  const dds_entity_t topic = must(dds_create_topic(participant, type->type, words[1], NULL, NULL), words[1]);
  const dds_entity_t writer = must(dds_create_writer(participant, topic, qos, NULL), words[1]);
  dds_publication_matched_status_t matched;
  do {
    usleep(10000);
    must(dds_get_publication_matched_status(writer, &matched), "matched");
  } while (matched.current_count == 0);
  usleep(1000000); /* waits until the reader has matched too */
  for (int number = 1; number <= atoi(words[2]); ++number) {
    union {
      test_Sample sample;
      test_Mixed mixed;
      line_BeltState state;
      line_Part part;
    } value;
    memset(&value, 0, sizeof value);
    type->fill(&value, (unsigned)number);
    must(dds_write(writer, &value), "write");
    usleep((useconds_t)atoi(words[3]) * 1000);
  }
  dds_wait_for_acks(writer, DDS_SECS(5));
  printf("written\n");
  return 0;
}

static int read_port(dds_entity_t participant, char **words) {
  const struct port_type *type = type_of(words[0]);
  dds_qos_t *qos = quality(words[4]);
  const dds_entity_t topic = must(dds_create_topic(participant, type->type, words[1], NULL, NULL), words[1]);
  const dds_entity_t reader = must(dds_create_reader(participant, topic, qos, NULL), words[1]);
  const int64_t end = wall_ns() + (int64_t)(atof(words[3]) * 1e9);
  int left = atoi(words[2]);
  while (left > 0 && wall_ns() < end) {
    void *samples[1] = {NULL};
    dds_sample_info_t info[1];
    const int count = dds_take(reader, samples, info, 1, 1);
    if (count > 0 && info[0].valid_data) {
      type->print(samples[0]);
      fflush(stdout);
      --left;
    }
    if (count > 0) {
      dds_return_loan(reader, samples, count);
    } else {
      usleep(1000);
    }
  }
  return left > 0 ? 1 : 0;
}

int main(int count, char **words) {
  if (count < 4) return 2;
  const dds_entity_t participant = must(dds_create_participant((dds_domainid_t)atoi(words[1]), NULL, NULL), "participant");
  int status = 2;
  if (strcmp(words[2], "watch") == 0) status = watch(participant, atof(words[3]));
  if (strcmp(words[2], "command") == 0 && count >= 6) status = ask(participant, count - 3, words + 3);
  if (strcmp(words[2], "write") == 0 && count == 8) status = write_port(participant, words + 3);
  if (strcmp(words[2], "read") == 0 && count == 8) status = read_port(participant, words + 3);
  dds_delete(participant);
  return status;
}
