#include "c_values.h"

#include <string.h>

static parts_Part part(uint8_t kind) {
  parts_Part value = {.kind = kind, .number = UINT64_C(0x1122334455667788) + kind};
  memset(value.label, 'p', kind % 8);
  return value;
}

void fill_whole(everything_Whole* value) {
  memset(value, 0, sizeof *value);
  value->scalars = (everything_Scalars){.flag = true,
                                        .byte = 200,
                                        .letter = 'L',
                                        .small = -2,
                                        .usmall = 65000,
                                        .whole = -70000,
                                        .uwhole = 4000000000U,
                                        .big = INT64_C(-5000000000),
                                        .ubig = UINT64_C(18000000000000000000),
                                        .single = 1.5F,
                                        .real = -2.25,
                                        .i8 = -8,
                                        .u8 = 8,
                                        .i16 = -16,
                                        .u16 = 16,
                                        .i32 = -32,
                                        .u32 = 32,
                                        .i64 = -64,
                                        .u64 = 64,
                                        .name = "12345678",
                                        .mode = parts_HOLD};
  strcpy(value->label, "1234567");
  value->piece = part(7);
  value->bottom = (everything_deep_Bottom){.mark = 'B', .depth = 11000.5};
  value->flags[0] = value->flags[2] = true;
  memcpy(value->letters, "hello", 5);
  double next = 0.5;
  for (int i = 0; i < everything_ROWS; ++i)
    for (int j = 0; j < everything_COLUMNS; ++j) value->matrix[i][j] = next++;
  strcpy(value->names[0][1], "a");
  strcpy(value->names[1][0], "bb");
  strcpy(value->names[1][1], "cccc");
  value->modes[1] = parts_ON;
  value->modes[2] = parts_HOLD;
  int32_t number = -3;
  for (int i = 0; i < 2; ++i)
    for (int j = 0; j < 2; ++j) value->pieces[i][j] = part((uint8_t)(++number + 10));
  for (int i = 0; i < 2; ++i)
    for (int j = 0; j < 3; ++j) value->plate[i][j] = number++;
  for (int k = 0; k < 2; ++k)
    for (int i = 0; i < 2; ++i)
      for (int j = 0; j < 3; ++j) value->plates[k][i][j] = number++ * 1000;
  value->flag_list.length = 5;
  for (int i = 0; i < 5; ++i) value->flag_list.items[i] = i % 2 == 0;
  value->byte_list.length = 7;
  for (int i = 0; i < 7; ++i) value->byte_list.items[i] = (uint8_t)(250 + i);
  value->letter_list.length = 3;
  memcpy(value->letter_list.items, "xyz", 3);
  value->small_list.length = 3;
  for (int i = 0; i < 3; ++i) value->small_list.items[i] = (int16_t)(-1000 * i);
  value->real_list.length = 4;
  for (int i = 0; i < 4; ++i) value->real_list.items[i] = 1.0 / (i + 1);
  value->name_list.length = 3;
  for (int i = 0; i < 3; ++i) memset(value->name_list.items[i], 'n', (size_t)(6 - i));
  value->mode_list.length = 3;
  for (int i = 0; i < 3; ++i) value->mode_list.items[i] = (parts_Mode)(2 - i);
  value->piece_list.length = 3;
  for (int i = 0; i < 3; ++i) value->piece_list.items[i] = part((uint8_t)(i + 5));
  value->plate_list.length = 2;
  for (int i = 0; i < 2; ++i) memcpy(value->plate_list.items[i], value->plate, sizeof value->plate);
  value->label_list.length = 6;
  for (int i = 0; i < 6; ++i) memset(value->label_list.items[i], 'l', (size_t)(i + 2));
  value->way.length = 4;
  for (int i = 0; i < 4; ++i) value->way.items[i] = 3.5;
  value->ways[0].length = 4;
  for (int i = 0; i < 4; ++i) value->ways[0].items[i] = 4.5;
  value->ways[1].length = 2;
  for (int i = 0; i < 2; ++i) value->ways[1].items[i] = 5.5;
  value->longs[0].length = 1;
  value->longs[0].items[0] = -6;
  value->longs[1].length = 2;
  value->longs[1].items[0] = value->longs[1].items[1] = 7;
  value->last = 1;
  value->more[0] = 2;
  value->more[1] = 3;
}
