// Recordings in Parquet files, as the text of a table. Loaded with the first such file, and not before.
import { parquetMetadata, parquetReadObjects, parquetSchema } from "hyparquet";
import type { Compressors } from "hyparquet";
import { decompressGzip, decompressLz4, decompressLz4Raw, decompressZstd } from "hyparquet-compressors";

/** What the command reads, too. Snappy is hyparquet's own. */
const COMPRESSORS: Compressors = {
  ZSTD: (packed) => decompressZstd(packed),
  GZIP: decompressGzip,
  LZ4: decompressLz4,
  LZ4_RAW: decompressLz4Raw,
};
const READ = ["UNCOMPRESSED", "SNAPPY", ...Object.keys(COMPRESSORS)];
const NUMBERS = ["DOUBLE", "FLOAT", "INT32", "INT64"];
/** Most rows of a recording, and most bytes of a column once it is unpacked. */
const MAX_ROWS = 5_000_000, MAX_BYTES = 1 << 28;

export interface Column {
  index: number;
  title: string;
}

/**
 * The columns of a recording as CSV, to the bit; an empty cell is none.
 * @param choose which columns are read, of all titles.
 * @throws what cannot be read, in a line for people.
 */
export const tableOf = async (file: ArrayBuffer, choose: (titles: string[]) => Promise<Column[]>): Promise<string> => {
  const unreadable = (error: unknown) => new Error(`cannot be read as Parquet: ${error instanceof Error ? error.message : error}`);
  let metadata;
  try {
    metadata = parquetMetadata(file);
  } catch (error) {
    throw unreadable(error);
  }
  const rows = Number(metadata.num_rows);
  if (rows > MAX_ROWS) throw new Error(`too many rows: ${rows}; expected at most ${MAX_ROWS}: cut the recording or sample it more coarsely`);
  const leaves = parquetSchema(metadata).children;
  const columns = await choose(leaves.map(({ element }) => element.name));
  for (const { index, title } of columns) {
    const { element, children } = leaves[index]!;
    const is_number = !children.length && element.repetition_type !== "REPEATED" && NUMBERS.includes(element.type ?? "") && !element.logical_type && !element.converted_type;
    if (!is_number) throw new Error(`${title}: not a column of numbers; expected one number in every row`);
    for (const group of metadata.row_groups) {
      const chunk = group.columns.find(({ meta_data }) => meta_data?.path_in_schema.join(".") === element.name)?.meta_data;
      if (chunk && !READ.includes(chunk.codec)) throw new Error(`${title}: its compression ${chunk.codec} is not read; expected one of ${READ.join(", ")}`);
      if (chunk && Number(chunk.total_uncompressed_size) > MAX_BYTES) throw new Error(`${title}: larger than ${MAX_BYTES >> 20} MiB`);
    }
  }
  const names = columns.map(({ index }) => leaves[index]!.element.name);
  let table: Record<string, unknown>[];
  try {
    table = await parquetReadObjects({ file, metadata, columns: names, compressors: COMPRESSORS });
  } catch (error) {
    throw unreadable(error);
  }
  const quoted = (name: string) => (/[",;\n\t]/.test(name) ? `"${name.replaceAll('"', '""')}"` : name);
  const cell = (value: unknown) => (value === null || value === undefined || Number.isNaN(value) ? "" : String(value));
  return [names.map(quoted).join(","), ...table.map((row) => names.map((name) => cell(row[name])).join(","))].join("\n");
};
