//! Columns of Parquet files, also those that are compressed by Zstandard, which the library leaves to us: its own way
//! needs a library in C.

use std::fs::File;
use std::io::{self, Read};
use std::sync::Arc;

use bytes::Bytes;
use parquet::basic::Compression;
use parquet::column::page::{Page, PageMetadata, PageReader};
use parquet::column::reader::{ColumnReader, get_column_reader};
use parquet::errors::{ParquetError, Result};
use parquet::file::metadata::ParquetMetaData;
use parquet::file::serialized_reader::SerializedPageReader;
use ruzstd::decoding::errors::{FrameDecoderError, ReadFrameHeaderError};
use ruzstd::decoding::{FrameDecoder, StreamingDecoder};

/// A reader of one column of one row group.
pub(crate) fn column_reader(
    file: &Arc<File>,
    metadata: &ParquetMetaData,
    group: usize,
    index: usize,
) -> Result<ColumnReader> {
    let group = metadata.row_group(group);
    let chunk = group.column(index);
    let rows = usize::try_from(group.num_rows())?;
    let pages: Box<dyn PageReader> = if matches!(chunk.compression(), Compression::ZSTD(_)) {
        // Read as they stand, and decompressed afterwards.
        let stored = chunk.clone().into_builder().set_compression(Compression::UNCOMPRESSED).build()?;
        let inner = SerializedPageReader::new(file.clone(), &stored, rows, None)?;
        Box::new(ZstandardPages { inner, most: u64::try_from(chunk.uncompressed_size())? })
    } else {
        Box::new(SerializedPageReader::new(file.clone(), chunk, rows, None)?)
    };
    Ok(get_column_reader(metadata.file_metadata().schema_descr().column(index), pages))
}

/// Pages that are compressed by Zstandard.
struct ZstandardPages {
    inner: SerializedPageReader<File>,
    /// The most bytes that a page may have when it is decompressed: all that the column has.
    most: u64,
}

impl ZstandardPages {
    fn decompressed(&self, mut page: Page) -> Result<Page> {
        match &mut page {
            Page::DataPage { buf, .. } | Page::DictionaryPage { buf, .. } => *buf = self.bytes(buf, 0)?,
            // Levels stand before the values, and are not compressed.
            Page::DataPageV2 { buf, def_levels_byte_len, rep_levels_byte_len, is_compressed, .. } if *is_compressed => {
                *buf = self.bytes(buf, *def_levels_byte_len as usize + *rep_levels_byte_len as usize)?;
                *is_compressed = false;
            }
            Page::DataPageV2 { .. } => {}
        }
        Ok(page)
    }

    /// Bytes that are decompressed but for the first ones.
    fn bytes(&self, bytes: &[u8], plain: usize) -> Result<Bytes> {
        let (head, mut frames) =
            bytes.split_at_checked(plain).ok_or_else(|| ParquetError::General("a page is too short".to_owned()))?;
        let mut out = head.to_vec();
        decompress(&mut frames, self.most, &mut out).map_err(|error| ParquetError::External(Box::new(error)))?;
        Ok(out.into())
    }
}

/// Appends what frames of Zstandard hold, at most so many bytes.
fn decompress(frames: &mut &[u8], most: u64, out: &mut Vec<u8>) -> io::Result<()> {
    let mut decoder = FrameDecoder::new();
    let mut left = most;
    while !frames.is_empty() {
        let frame = match StreamingDecoder::new_with_decoder(&mut *frames, &mut decoder) {
            Ok(frame) => frame,
            // A frame that holds no data.
            Err(FrameDecoderError::ReadFrameHeaderError(ReadFrameHeaderError::SkipFrame { length, .. })) => {
                *frames = frames.get(length as usize..).unwrap_or_default();
                continue;
            }
            Err(error) => return Err(io::Error::other(error.to_string())),
        };
        let read = frame.take(left + 1).read_to_end(out)? as u64;
        left = left.checked_sub(read).ok_or_else(|| io::Error::other("a page is longer than its column"))?;
    }
    Ok(())
}

impl Iterator for ZstandardPages {
    type Item = Result<Page>;

    fn next(&mut self) -> Option<Self::Item> {
        self.get_next_page().transpose()
    }
}

impl PageReader for ZstandardPages {
    fn get_next_page(&mut self) -> Result<Option<Page>> {
        self.inner.get_next_page()?.map(|page| self.decompressed(page)).transpose()
    }

    fn peek_next_page(&mut self) -> Result<Option<PageMetadata>> {
        self.inner.peek_next_page()
    }

    fn skip_next_page(&mut self) -> Result<()> {
        self.inner.skip_next_page()
    }

    fn at_record_boundary(&mut self) -> Result<bool> {
        self.inner.at_record_boundary()
    }
}
